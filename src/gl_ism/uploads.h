/* ---- ism: meshes, surfels, VPLs and near points from the CPU ---- */

/* Writes count strided triples into a table of four floats each, which is made if there is none yet, or has
   as many; from NULL: 0.5 everywhere. */
static glbk_result glbk__ism_upload(glbk_context *ctx, glbk_texture *table, const float *from, size_t count,
                                   size_t stride)
{
    glbk_ism__allocator memory = glbk_ism__memory(ctx);
    float *texels = (float *)glbk_ism__alloc_array(&memory, count, 16);
    glbk_result result;
    size_t i;
    if (!texels) return GLBK_ERR_ALLOC;
    for (i = 0; i < 4 * count; i++) texels[i] = 0.5f;
    for (i = 0; i < count && from; i++)
        memcpy(texels + 4 * i, (const char *)from + (stride ? stride : 12) * i, 12);
    result = table->name ? glbk__table_update(ctx, table, 0, count, texels)
                         : glbk__table_create(ctx, GLBK_FORMAT_RGBA32F, texels, count, table);
    glbk_ism__free(&memory, texels);
    return result;
}

/* Returns three indices and the bits of the opacity of each triangle, in memory that the caller frees.
   Returns NULL if there is no memory or an index reaches beyond the vertices; *result says which. */
static uint32_t *glbk__ism_triangles(const glbk_context *ctx, const glbk_ism__allocator *memory,
                                     const ism_mesh *mesh, size_t count, glbk_result *result)
{
    uint32_t *words = (uint32_t *)glbk_ism__alloc_array(memory, count, 16);
    float opacity = 1;
    size_t i, corner;
    *result = words ? GLBK_OK : GLBK_ERR_ALLOC;
    for (corner = 0; corner < 3 * count && *result == GLBK_OK; corner++) {
        const uint32_t index = mesh->indices     ? mesh->indices[corner]
                               : mesh->indices16 ? mesh->indices16[corner]
                                                 : (uint32_t)corner;
        words[corner / 3 * 4 + corner % 3] = index;
        if (index >= mesh->vertex_count)
            *result = glbk__refuse_index(ctx, GLBK_ERR_INPUT, "glbk_ism_mesh_upload", "mesh", corner, index,
                                         mesh->vertex_count);
    }
    for (i = 0; i < count && *result == GLBK_OK; i++) {
        if (mesh->opacities) opacity = mesh->opacities[i];
        memcpy(words + 4 * i + 3, &opacity, 4);
    }
    if (words && *result != GLBK_OK) {
        glbk_ism__free(memory, words);
        words = NULL;
    }
    return words;
}

/* Replaces triangles, positions and albedos by those of a mesh that has some, or leaves all as they are. */
static glbk_result glbk__ism_replace_mesh(glbk_context *ctx, glbk_ism_maps *m, const ism_mesh *mesh,
                                          size_t count)
{
    const glbk_ism__allocator memory = glbk_ism__memory(ctx);
    glbk_texture made[3], old, *tables[3];
    glbk_result result;
    int k;
    uint32_t *words = glbk__ism_triangles(ctx, &memory, mesh, count, &result);
    if (!words) return result;
    memset(made, 0, sizeof made);
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, words, count, &made[0]);
    glbk_ism__free(&memory, words);
    if (result == GLBK_OK)
        result = glbk__ism_upload(ctx, &made[1], mesh->positions, mesh->vertex_count, mesh->vertex_stride);
    if (result == GLBK_OK && m->desc.keep_hits)
        result = glbk__ism_upload(ctx, &made[2], mesh->albedos, count, 0);
    if (result == GLBK_OK) m->vertex_count = (uint32_t)mesh->vertex_count;
    tables[0] = &m->triangle_table;
    tables[1] = &m->positions;
    tables[2] = &m->albedos;
    for (k = 0; k < 3 && made[k].name; k++) {
        old = *tables[k];
        if (result == GLBK_OK) *tables[k] = made[k];
        glbk_texture_free(ctx, result == GLBK_OK ? &old : &made[k]);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_mesh *mesh)
{
    size_t count = 0;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK && mesh) {
        result = glbk__ism_check_mesh(ctx, __func__, mesh);
        count = (mesh->indices || mesh->indices16 ? mesh->index_count : mesh->vertex_count) / 3;
    }
    if (result == GLBK_OK && count) result = glbk__ism_replace_mesh(ctx, m, mesh, count);
    if (result != GLBK_OK) return result;
    if (!count) m->phases = 0;
    m->fewer |= count < m->triangle_count;
    m->outdated |= count < m->triangle_count;
    m->triangle_count = (uint32_t)count;
    m->masked = mesh && mesh->mask_fn != NULL;
    return glbk__leave_created(ctx, glbk__ism_write_frame(ctx, m));
}

GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *m, const float *positions,
                                        size_t stride)
{
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "positions", positions);
    if (result != GLBK_OK) return result;
    if (!glbk_ism__stride_valid(stride, 12))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "stride", (double)stride,
                                  "0 or a multiple of 4, at least 12");
    if (!m->triangle_count)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "have no mesh: glbk_ism_mesh_upload");
    return glbk__ism_upload(ctx, &m->positions, positions, m->vertex_count, stride);
}

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase,
                                             const ism_surfel *surfels, size_t count)
{
    size_t wanted;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "surfels", surfels);
    if (result != GLBK_OK) return result;
    if (phase >= m->desc.lazy_frames)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "phase", phase, 0,
                                  m->desc.lazy_frames - 1.0);
    wanted = (size_t)m->desc.vpl_count * m->phase_surfel_count;
    if (count != wanted) return glbk__ism_refuse_size(ctx, __func__, "count", count, wanted);
    result = m->compute ? glbk__table_update(ctx, &m->surfels, count * phase, count, surfels)
                        : glbk__table_update(ctx, &m->phase_surfels[phase], 0, count, surfels);
    if (result == GLBK_OK) m->phases |= (uint64_t)1 << phase;
    return result;
}

/* Writes the four texels of a VPL, which docs/gpu-layouts.md lists. Maps without a rim have no windows. */
static void glbk__ism_pack_vpl(const glbk_ism_maps *m, const ism_vpl *v, float *to)
{
    memcpy(to, v->position, 12);
    to[3] = v->directional ? -1 : v->exponent;
    memcpy(to + 4, v->normal, 12);
    to[7] = v->edge;
    memcpy(to + 8, v->flux, 12);
    to[11] = v->reach;
    memcpy(to + 12, v->axis, 12);
    to[15] = m->desc.window_rim ? (float)v->window : 0.0f;
}

/* Checks all arguments of glbk_ism_vpls_upload. */
static glbk_result glbk__ism_check_vpls(const glbk_context *ctx, const char *function, const glbk_ism_maps *m,
                                        const ism_vpl *vpls, uint32_t count, const ism_info *info)
{
    glbk_result result = glbk__ism_check_maps(ctx, function, m);
    uint32_t i;
    if (result != GLBK_OK) return result;
    if (count && !vpls) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "vpls", "is NULL");
    if (!info) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "info", "is NULL");
    if (count > m->desc.vpl_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "count", count, 0, m->desc.vpl_count);
    result = glbk__ism_check_info(ctx, function, &m->desc, info);
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__ism_check_vpl(ctx, &vpls[i], i);
        if (result == GLBK_OK && vpls[i].directional && !(info->radius > 0))
            result = glbk__refuse(ctx, GLBK_ERR_INPUT, function, "info.radius",
                                  "is 0; it must be above 0, since there is a directional VPL");
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_vpl *vpls,
                                          uint32_t count, const ism_info *info)
{
    glbk_result result = glbk__ism_check_vpls(ctx, __func__, m, vpls, count, info);
    if (result == GLBK_OK && count) {
        const glbk_ism__allocator memory = glbk_ism__memory(ctx);
        float *texels = (float *)glbk_ism__alloc_array(&memory, count, 64);
        uint32_t i;
        if (!texels) return GLBK_ERR_ALLOC;
        for (i = 0; i < count; i++) glbk__ism_pack_vpl(m, &vpls[i], texels + 16 * (size_t)i);
        result = glbk__table_update(ctx, &m->vpls, 0, 4 * (size_t)count, texels);
        glbk_ism__free(&memory, texels);
    }
    if (result != GLBK_OK) return result;
    m->vpl_count = count;
    m->near_point_count = 0;
    memcpy(m->sphere, info->center, sizeof info->center);
    m->sphere[3] = info->radius > 0 ? info->radius : 1;
    return glbk__ism_write_frame(ctx, m);
}

/* Computes centre and radius of the sphere beyond which none of the near points reaches, as ism.h does. */
static void glbk__ism_near_sphere(const ism_near_point *points, uint32_t count, float sphere[4])
{
    float low[3], high[3], d2, reach;
    uint32_t i, k;
    memcpy(low, points[0].position, sizeof low);
    memcpy(high, points[0].position, sizeof high);
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            const float x = points[i].position[k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    for (k = 0; k < 3; k++) sphere[k] = 0.5f * (low[k] + high[k]);
    sphere[3] = 0;
    for (i = 0; i < count; i++) {
        const float *p = points[i].position;
        for (k = 0, d2 = 0; k < 3; k++) d2 += (p[k] - sphere[k]) * (p[k] - sphere[k]);
        reach = sqrtf(d2) + points[i].reach;
        if (reach > sphere[3]) sphere[3] = reach;
    }
}

/* Sends near points as they are, and a sphere about each 64 of them. */
static glbk_result glbk__ism_send_near_points(glbk_context *ctx, glbk_ism_maps *m,
                                              const ism_near_point *points, uint32_t count)
{
    const glbk_ism__allocator memory = glbk_ism__memory(ctx);
    const size_t behind = (size_t)glbk__ism_vpl_texels(m) + glbk__ism_spheres(m);
    const uint32_t blocks = (count + 63) / 64;
    float *spheres = (float *)glbk_ism__alloc_array(&memory, blocks, 16);
    glbk_result result;
    uint32_t i;
    if (!spheres) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i += 64)
        glbk__ism_near_sphere(points + i, count - i < 64 ? count - i : 64, spheres + i / 16);
    result = glbk__table_update(ctx, &m->vpls, glbk__ism_vpl_texels(m), blocks, spheres);
    glbk_ism__free(&memory, spheres);
    if (result != GLBK_OK) return result;
    return glbk__table_update(ctx, &m->vpls, behind, 3 * (size_t)count, points);
}

GLBK_DEF glbk_result glbk_ism_near_points_upload(glbk_context *ctx, glbk_ism_maps *m,
                                                 const ism_near_point *points, uint32_t count)
{
    glbk_result result;
    uint32_t i;
    result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    if (count && !points) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points", "is NULL");
    if (count > m->desc.vpl_count * (uint32_t)m->desc.near_point_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", count, 0,
                                  (double)m->desc.vpl_count * (double)m->desc.near_point_count);
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__ism_check_near_point(ctx, &points[i], i, m->vpl_count);
    if (result != GLBK_OK) return result;
    if (count) result = glbk__ism_send_near_points(ctx, m, points, count);
    m->near_point_count = result == GLBK_OK ? count : 0;
    return result == GLBK_OK ? glbk__ism_write_frame(ctx, m) : result;
}
