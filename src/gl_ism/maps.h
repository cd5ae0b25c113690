/* ---- ism: maps, meshes and VPLs ---- */

static int glbk__ism_resolve(glbk_ism_desc *d)
{
    if (d->vpl_count > 16384 || (d->points && d->points < 8) || d->points > 65536 || d->projection > 4 ||
        d->lazy > 64 || d->near_points > 64 ||
        (d->tile_size && (d->tile_size < 8 || d->tile_size > 256 || (d->tile_size & (d->tile_size - 1)))) ||
        !(d->splat_scale >= 0 && d->splat_scale <= 16) || d->window_rim == 1 ||
        d->window_rim > (d->tile_size ? d->tile_size : 64) / 2)
        return 0;
    if (!d->vpl_count) d->vpl_count = 1024;
    if (!d->points) d->points = 8192;
    if (!d->tile_size) d->tile_size = 64;
    if (!d->window_rim) d->window_rim = d->tile_size < 16 ? 2 : d->tile_size / 8;
    if (!d->projection) d->projection = 1;
    if (!d->lazy) d->lazy = 8;
    if (!d->near_points) d->near_points = 16;
    if (!(d->splat_scale > 0)) d->splat_scale = 1.0f;
    if (!d->points_per_pass) d->points_per_pass = 1u << 20;
    return 1;
}

/* What both paths draw: surfels, the atlas. */
static glbk_result glbk__ism_create_canvases(glbk_context *ctx, glbk_ism_maps *m)
{
    const glbk_texture *depth = NULL;
    glbk_texture_desc d;
    glbk_result result = GLBK_OK;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_DEPTH32F;
    d.width = d.height = m->side;
    if (!m->compute) {
        result = glbk_texture_create(ctx, &d, &m->depth);
        depth = &m->depth;
    }
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, m->side, m->side, depth, &m->surfels, &m->surfel_target);
    return result == GLBK_OK ? glbk__canvas(ctx, GLBK_FORMAT_R32UI, m->side, m->side, NULL, &m->atlas, &m->atlas_target)
                             : result;
}

/* What the core path needs from surfels to the atlas. */
static glbk_result glbk__ism_create_fill(glbk_context *ctx, glbk_ism_maps *m, const char *projection)
{
    char defines[] = "ISM_LEVEL=1";
    glbk_result result = glbk__canvas(ctx, GLBK_FORMAT_R8UI, m->side, m->side, NULL, &m->kept, &m->kept_target);
    uint32_t i;
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, glbk_ism_part(), "ism_holes.frag", projection, &m->holes);
    for (i = 0; i < GLBK_ISM_LEVELS && result == GLBK_OK; i++) {
        result = glbk__canvas(ctx, GLBK_FORMAT_R32UI, m->side >> (i + 1), m->side >> (i + 1), NULL, &m->pull[i],
                              &m->pull_target[i]);
        defines[10] = (char)('1' + (int)i);
        if (result == GLBK_OK)
            result = glbk_program_create(ctx, glbk_ism_part(), "ism_pull.frag", defines, &m->pull_program[i]);
    }
    return result == GLBK_OK ? glbk_program_create(ctx, glbk_ism_part(),
                                                   "ism_push.frag", projection, &m->push) : result;
}

static glbk_result glbk__ism_create_programs(glbk_context *ctx, glbk_ism_maps *m)
{
    char defines[] = "ISM_PROJECTION=1 ISM_QUADS=0";
    glbk_result result;
    m->quads = !m->compute && ctx->max_point_side < (float)m->desc.tile_size;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[27] = m->quads ? '1' : '0';
    result = glbk_program_create(ctx, glbk_ism_part(),
                                 m->compute ? "ism_splat.comp" : "ism_splat.frag", defines, &m->splat);
    if (result != GLBK_OK) return result;
    if (!m->compute) return glbk__ism_create_fill(ctx, m, defines);
    return glbk_program_create(ctx, glbk_ism_part(), "ism_fill.comp", defines, &m->fill);
}

/* Levels of pull and push: the coarsest has two cells a side of a tile at least. */
static uint32_t glbk__ism_levels(const glbk_ism_maps *m)
{
    uint32_t levels = m->desc.no_fill ? 0 : GLBK_ISM_LEVELS;
    while (levels && m->desc.tile_size >> levels < 2) levels--;
    return levels;
}

/* Texels of the table of VPLs before the near points' spheres, and of these. */
static uint32_t glbk__ism_vpl_texels(const glbk_ism_maps *m) { return 4 * m->desc.vpl_count; }
static uint32_t glbk__ism_spheres(const glbk_ism_maps *m)
{
    return (m->desc.vpl_count * m->desc.near_points + 63) / 64;
}

static glbk_ism_frame glbk__ism_frame_of(const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    memset(&f, 0, sizeof f);
    f.maps[0] = m->count;
    f.maps[1] = m->desc.tile_size;
    f.maps[2] = m->tiles;
    f.maps[3] = m->each * m->desc.lazy;
    f.points[0] = m->desc.vpl_count;
    f.points[1] = m->each;
    f.points[2] = glbk__ism_levels(m);
    f.points[3] = m->triangles;
    memcpy(f.sphere, m->sphere, sizeof f.sphere);
    f.values[0] = m->desc.splat_scale;
    f.values[1] = (float)m->desc.window_rim;
    f.near_points[0] = m->near_count;
    f.near_points[1] = glbk__ism_vpl_texels(m);
    f.near_points[2] = f.near_points[1] + glbk__ism_spheres(m);
    return f;
}

static glbk_result glbk__ism_write_frame(glbk_context *ctx, const glbk_ism_maps *m)
{
    const glbk_ism_frame f = glbk__ism_frame_of(m);
    return glbk_buffer_update(ctx, &m->frame, 0, sizeof f, &f);
}

/* By compute one table, since a dispatch reads all phases. Else one for each: it is written while the frame before may
   still be drawn, and GPUs that keep frames in flight copy the whole of a texture that is. */
static glbk_result glbk__ism_create_points(glbk_context *ctx, glbk_ism_maps *m, size_t points)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    if (m->compute) return glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, points, &m->points);
    for (i = 0; i < m->desc.lazy && result == GLBK_OK; i++)
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, points / m->desc.lazy, &m->phase_points[i]);
    return result;
}

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const glbk_ism_desc *desc, glbk_ism_maps *out)
{
    static const uint32_t nothing[4] = { 0, 0, 0, 0 };
    size_t points;
    glbk_result result;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (desc) out->desc = *desc;
    if (!glbk__ism_resolve(&out->desc)) return memset(out, 0, sizeof *out), GLBK_ERR_ARGUMENT;
    for (out->tiles = 1; out->tiles * out->tiles < out->desc.vpl_count; out->tiles++) {}
    out->side = out->tiles * out->desc.tile_size;
    out->each = (out->desc.points + out->desc.lazy - 1) / out->desc.lazy;
    points = (size_t)out->each * out->desc.lazy * out->desc.vpl_count;
    if (out->side > ctx->max_side || points > 0x7fffffff) return memset(out, 0, sizeof *out), GLBK_ERR_LIMIT;
    out->compute = ctx->compute && out->each * out->desc.lazy <= 65536;     /* ism_splat.comp counts them in 16 bits */
    result = glbk__ism_create_points(ctx, out, points);
    if (result == GLBK_OK)
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, NULL,
                                   glbk__ism_vpl_texels(out) + glbk__ism_spheres(out) +
                                       3 * (size_t)out->desc.vpl_count * out->desc.near_points, &out->vpls);
    if (result == GLBK_OK) result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, nothing, 1, &out->triangle_table);
    if (result == GLBK_OK) result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, nothing, 1, &out->positions);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_view), NULL, &out->view);
    if (result == GLBK_OK) result = glbk__ism_create_canvases(ctx, out);
    if (result == GLBK_OK) result = glbk__ism_create_programs(ctx, out);
    if (result == GLBK_OK) result = glbk__made(ctx, glbk__ism_write_frame(ctx, out));
    if (result != GLBK_OK) glbk_ism_maps_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i;
    if (!m) return;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        glbk_program_free(ctx, &m->pull_program[i]);
        glbk_target_free(ctx, &m->pull_target[i]);
        glbk_texture_free(ctx, &m->pull[i]);
    }
    glbk_program_free(ctx, &m->splat);
    glbk_program_free(ctx, &m->holes);
    glbk_program_free(ctx, &m->push);
    glbk_program_free(ctx, &m->fill);
    glbk_target_free(ctx, &m->surfel_target);
    glbk_target_free(ctx, &m->kept_target);
    glbk_target_free(ctx, &m->atlas_target);
    glbk_texture_free(ctx, &m->vpls);
    glbk_texture_free(ctx, &m->points);
    for (i = 0; i < 64; i++) glbk_texture_free(ctx, &m->phase_points[i]);
    glbk_texture_free(ctx, &m->triangle_table);
    glbk_texture_free(ctx, &m->positions);
    glbk_texture_free(ctx, &m->surfels);
    glbk_texture_free(ctx, &m->depth);
    glbk_texture_free(ctx, &m->kept);
    glbk_texture_free(ctx, &m->atlas);
    glbk_buffer_free(ctx, &m->frame);
    glbk_buffer_free(ctx, &m->view);
    memset(m, 0, sizeof *m);
}


/* count strided triples into a table of four floats each, at least one texel; the table is made anew where it is too
 * small. */
static glbk_result glbk__ism_upload(glbk_context *ctx, glbk_texture *table, uint32_t had, const float *from,
                                    size_t count, size_t stride)
{
    glbk_ism__allocator memory = glbk_ism__memory(ctx);
    float *texels = (float *)glbk_ism__alloc_array(&memory, count ? count : 1, 16);
    glbk_texture made;
    glbk_result result;
    size_t i;
    if (!texels) return GLBK_ERR_ALLOC;
    memset(texels, 0, 16 * (count ? count : 1));
    for (i = 0; i < count; i++) memcpy(texels + 4 * i, (const char *)from + (stride ? stride : 12) * i, 12);
    if (table->name && count == had && count) {
        result = glbk_table_update(ctx, table, 0, count, texels);
    } else {
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, texels, count ? count : 1, &made);
        if (result == GLBK_OK) {
            glbk_texture_free(ctx, table);
            *table = made;
        }
    }
    glbk_ism__free(&memory, texels);
    return result;
}

/* Three indices and the bits of the opacity, or NULL where memory (result) or an index (its error) fails. */
static uint32_t *glbk__ism_triangles(const glbk_ism__allocator *memory, const ism_mesh *mesh, size_t count,
                                     glbk_result *result)
{
    uint32_t *words = (uint32_t *)glbk_ism__alloc_array(memory, count, 16);
    float opacity = 1;
    size_t i, k;
    *result = words ? GLBK_OK : GLBK_ERR_ALLOC;
    for (i = 0; i < count && *result == GLBK_OK; i++) {
        for (k = 0; k < 3; k++) {
            words[4 * i + k] = mesh->indices     ? mesh->indices[3 * i + k]
                               : mesh->indices16 ? mesh->indices16[3 * i + k]
                                                 : (uint32_t)(3 * i + k);
            if (words[4 * i + k] >= mesh->vertex_count) *result = GLBK_ERR_ARGUMENT;
        }
        if (mesh->opacities) opacity = mesh->opacities[i];
        memcpy(words + 4 * i + 3, &opacity, 4);
    }
    if (words && *result != GLBK_OK) {
        glbk_ism__free(memory, words);
        words = NULL;
    }
    return words;
}

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_mesh *mesh)
{
    glbk_ism__allocator memory;
    uint32_t *words;
    const int indexed = mesh && (mesh->indices || mesh->indices16);
    size_t corners = mesh ? (indexed ? mesh->index_count : mesh->vertex_count) : 0, count = corners / 3;
    glbk_texture made;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name || (mesh && !glbk_ism__stride_valid(mesh->vertex_stride, 12)) || corners % 3 ||
        (corners && !mesh->positions) || (indexed && mesh->indices && mesh->indices16))
        return GLBK_ERR_ARGUMENT;
    if (corners > 0x7fffffff || (mesh && mesh->vertex_count > 0x7fffffff)) return GLBK_ERR_LIMIT;
    if (count) {
        memory = glbk_ism__memory(ctx);
        words = glbk__ism_triangles(&memory, mesh, count, &result);
        if (!words) return result;
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, words, count, &made);
        glbk_ism__free(&memory, words);
        if (result == GLBK_OK) {
            result = glbk__ism_upload(ctx, &m->positions, m->vertices, mesh->positions, mesh->vertex_count,
                                      mesh->vertex_stride);
            if (result != GLBK_OK) glbk_texture_free(ctx, &made);
        }
        if (result != GLBK_OK) return result;
        glbk_texture_free(ctx, &m->triangle_table);
        m->triangle_table = made;
        m->vertices = (uint32_t)mesh->vertex_count;
    }
    if (count != m->triangles) m->phases = 0;
    m->triangles = (uint32_t)count;
    return glbk__made(ctx, glbk__ism_write_frame(ctx, m));
}

GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *m, const float *positions, size_t stride)
{
    if (!ctx || !m || !m->triangles || !positions || !glbk_ism__stride_valid(stride, 12)) return GLBK_ERR_ARGUMENT;
    return glbk__ism_upload(ctx, &m->positions, m->vertices, positions, m->vertices, stride);
}

GLBK_DEF glbk_result glbk_ism_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase, const void *points)
{
    size_t count;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name || !points || phase >= m->desc.lazy) return GLBK_ERR_ARGUMENT;
    count = (size_t)m->desc.vpl_count * m->each;
    result = m->compute ? glbk_table_update(ctx, &m->points, count * phase, count, points)
                        : glbk_table_update(ctx, &m->phase_points[phase], 0, count, points);
    if (result == GLBK_OK) m->phases |= (uint64_t)1 << phase;
    return result;
}

static int glbk__ism_vpl_ok(const ism_vpl *v)
{
    float sum = v->exponent + v->side + v->reach;
    int k;
    for (k = 0; k < 3; k++) sum += v->position[k] * 0 + v->normal[k] * 0 + v->flux[k] * 0 + v->axis[k] * 0;
    for (k = 0; k < 2; k++)         /* something is left of each side */
        if ((v->window >> 6 * k & 63) + (v->window >> (6 * k + 12) & 63) > 63) return 0;
    return sum >= 0 && v->exponent >= 0 && v->exponent <= 1e5f && v->side >= 0 && v->reach >= 0 &&
           sum < 3e38f && v->window < 1u << 24;
}

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_vpl *vpls, uint32_t count,
                                          const float center[3], float radius)
{
    glbk_ism__allocator memory;
    glbk_result result = GLBK_OK;
    float *texels;
    uint32_t i;
    if (!ctx || !m || !m->vpls.name || (count && !vpls) || count > m->desc.vpl_count || (center && !(radius > 0)))
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++)
        if (!glbk__ism_vpl_ok(&vpls[i]) || (vpls[i].directional && !center)) return GLBK_ERR_ARGUMENT;
    if (count) {
        memory = glbk_ism__memory(ctx);
        texels = (float *)glbk_ism__alloc_array(&memory, count, 64);
        if (!texels) return GLBK_ERR_ALLOC;
        for (i = 0; i < count; i++) {
            float *to = texels + 16 * (size_t)i;
            memcpy(to, vpls[i].position, 12);
            to[3] = vpls[i].directional ? -1 : vpls[i].exponent;
            memcpy(to + 4, vpls[i].normal, 12);
            to[7] = vpls[i].side;
            memcpy(to + 8, vpls[i].flux, 12);
            to[11] = vpls[i].reach;
            memcpy(to + 12, vpls[i].axis, 12);
            to[15] = (float)vpls[i].window;
        }
        result = glbk_table_update(ctx, &m->vpls, 0, 4 * (size_t)count, texels);
        glbk_ism__free(&memory, texels);
    }
    if (result != GLBK_OK) return result;
    m->count = count;
    m->near_count = 0;
    memset(m->sphere, 0, sizeof m->sphere);
    if (center) memcpy(m->sphere, center, 3 * sizeof(float));
    m->sphere[3] = center ? radius : 1;
    return glbk__ism_write_frame(ctx, m);
}

/* x, y, z and radius of the sphere beyond which none of them reaches, as ism.h has it. */
static void glbk__ism_near_sphere(const float *points, uint32_t count, float sphere[4])
{
    float lo[3], hi[3], d2, reach;
    uint32_t i, k;
    for (k = 0; k < 3; k++) lo[k] = hi[k] = points[k];
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            lo[k] = points[12 * i + k] < lo[k] ? points[12 * i + k] : lo[k];
            hi[k] = points[12 * i + k] > hi[k] ? points[12 * i + k] : hi[k];
        }
    for (k = 0; k < 3; k++) sphere[k] = 0.5f * (lo[k] + hi[k]);
    sphere[3] = 0;
    for (i = 0; i < count; i++) {
        for (k = 0, d2 = 0; k < 3; k++) d2 += (points[12 * i + k] - sphere[k]) * (points[12 * i + k] - sphere[k]);
        reach = sqrtf(d2) + points[12 * i + 7];
        if (reach > sphere[3]) sphere[3] = reach;
    }
}

GLBK_DEF glbk_result glbk_ism_near_upload(glbk_context *ctx, glbk_ism_maps *m, const void *points, uint32_t count)
{
    const float *values = (const float *)points;
    glbk_ism__allocator memory;
    glbk_result result;
    float *spheres;
    uint32_t i, k;
    if (!ctx || !m || !m->vpls.name || (count && !points) || count > m->desc.vpl_count * m->desc.near_points)
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        const float *p = values + 12 * (size_t)i;
        float sum = 0;
        for (k = 0; k < 12; k++) sum += p[k] * 0;
        if (!(sum >= 0 && p[3] >= 0 && p[7] >= 0 && p[11] >= 0 && p[11] < (float)m->count)) return GLBK_ERR_ARGUMENT;
    }
    m->near_count = count;
    if (!count) return glbk__ism_write_frame(ctx, m);
    memory = glbk_ism__memory(ctx);
    spheres = (float *)glbk_ism__alloc_array(&memory, (count + 63) / 64, 16);
    if (!spheres) return m->near_count = 0, GLBK_ERR_ALLOC;
    for (i = 0; i < count; i += 64)
        glbk__ism_near_sphere(values + 12 * (size_t)i, count - i < 64 ? count - i : 64, spheres + i / 16);
    result = glbk_table_update(ctx, &m->vpls, glbk__ism_vpl_texels(m), (count + 63) / 64, spheres);
    glbk_ism__free(&memory, spheres);
    if (result == GLBK_OK)
        result = glbk_table_update(ctx, &m->vpls, (size_t)glbk__ism_vpl_texels(m) + glbk__ism_spheres(m),
                                   3 * (size_t)count, points);
    if (result != GLBK_OK) m->near_count = 0;
    return result == GLBK_OK ? glbk__ism_write_frame(ctx, m) : result;
}
