/* ---- sfield: building: meshes, textures and programs ---- */

enum {
    GLBK__SFIELD_TILES = 256,       /* the most tiles of an atlas, as the uniform block has them */
    GLBK__SFIELD_BATCH = 128,       /* the most eyes */
    GLBK__SFIELD_VERTEX_ARRAY_BINDING = 0x85B5,     /* a constant of GL, like the next one */
    GLBK__SFIELD_ARRAY_BUFFER_BINDING = 0x8894
};

/* Returns how many numbers an eye has in a channel: coefficients, or texels of a cube. */
static size_t glbk__sfield_values(const glbk_sfield_builder *b)
{
    return b->bands ? (size_t)b->bands * b->bands : (size_t)6 * b->side * b->side;
}

/* Returns how many corners all triangles have. glbk__sfield_mesh_index returns the vertex of a corner,
   glbk__sfield_vertex the place of a vertex. */
static size_t glbk__sfield_mesh_corners(const sfield_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t glbk__sfield_mesh_index(const sfield_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

static const float *glbk__sfield_vertex(const sfield_mesh *m, size_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    return (const float *)(const void *)((const char *)(const void *)m->positions + i * stride);
}

/* Writes the corners of triangle t, whose indices are in range. Returns 0 if sfield_build would skip it. */
static int glbk__sfield_corners(const sfield_mesh *m, size_t t, uint32_t corner[3])
{
    int i, k;
    for (i = 0; i < 3; i++) {
        const float *p;
        corner[i] = glbk__sfield_mesh_index(m, 3 * t + (size_t)i);
        p = glbk__sfield_vertex(m, corner[i]);
        for (k = 0; k < 3; k++)
            if (!(fabsf(p[k]) < 1e18f)) return 0;
    }
    return 1;
}

/* Fits the sphere by which faces are chosen. Returns 0 if no triangle can be used. */
static int glbk__sfield_fit(const sfield_mesh *m, glbk_sfield_builder *b)
{
    const size_t triangles = glbk__sfield_mesh_corners(m) / 3;
    float low[3] = { 2e18f, 2e18f, 2e18f }, high[3] = { -2e18f, -2e18f, -2e18f }, r2 = 0;
    uint32_t corner[3];
    size_t t;
    int pass, i, k;
    for (pass = 0; pass < 2; pass++) {
        for (t = 0; t < triangles; t++) {
            if (!glbk__sfield_corners(m, t, corner)) continue;
            for (i = 0; i < 3; i++) {
                const float *p = glbk__sfield_vertex(m, corner[i]);
                float sum = 0;
                for (k = 0; k < 3; k++) {
                    low[k] = p[k] < low[k] ? p[k] : low[k];
                    high[k] = p[k] > high[k] ? p[k] : high[k];
                    sum += (p[k] - b->center[k]) * (p[k] - b->center[k]);
                }
                r2 = pass && sum > r2 ? sum : r2;
            }
        }
        for (k = 0; k < 3; k++) b->center[k] = 0.5f * low[k] + 0.5f * high[k];
    }
    b->radius = sqrtf(r2);
    return low[0] <= high[0];
}

/* Uploads vertices and the indices of usable triangles; of sources, three corners with their radiance for
   each triangle. */
static glbk_result glbk__sfield_upload_mesh(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                            glbk_sfield_builder *b)
{
    const sfield_mesh *m = d->mesh;
    const size_t triangles = glbk__sfield_mesh_corners(m) / 3;
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const size_t vertices = d->source ? 3 * triangles : m->vertex_count, floats = d->source ? 6 : 3;
    size_t t, i, n = 0;
    float *vertex = (float *)glbk_sfield__alloc_array(&memory, vertices, floats * sizeof *vertex),
          *v = vertex;
    uint32_t *index = (uint32_t *)glbk_sfield__alloc_array(&memory, triangles, 3 * sizeof *index), corner[3];
    glbk_result result = vertex && index ? GLBK_OK : GLBK_ERR_ALLOC;

    for (i = 0; i < vertices && !d->source && result == GLBK_OK; i++)
        memcpy(vertex + 3 * i, glbk__sfield_vertex(m, i), 12);
    for (t = 0; t < triangles && result == GLBK_OK; t++) {
        if (!glbk__sfield_corners(m, t, corner)) continue;
        for (i = 0; i < 3; i++, n++) {
            index[n] = d->source ? (uint32_t)n : corner[i];
            if (!d->source) continue;
            memcpy(v, glbk__sfield_vertex(m, corner[i]), 12);
            memcpy(v + 3, d->radiance + 3 * t, 12);
            v += 6;
        }
    }
    b->index_count = (uint32_t)n;
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, vertices * floats * sizeof *vertex, vertex, &b->vertices);
    if (result == GLBK_OK) result = glbk_indices_create(ctx, n * sizeof *index, index, &b->indices);
    glbk_sfield__free(&memory, vertex);
    glbk_sfield__free(&memory, index);
    return result;
}

/* Makes the vertex array of the mesh, and leaves GL's state as it was. */
static glbk_result glbk__sfield_vertex_array(glbk_context *ctx, glbk_sfield_builder *b)
{
    int32_t array = 0, buffer = 0, stride = b->source ? 24 : 12;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(GLBK__SFIELD_VERTEX_ARRAY_BINDING, &array);
    ctx->gl.GetIntegerv(GLBK__SFIELD_ARRAY_BUFFER_BINDING, &buffer);
    ctx->gl.GenVertexArrays(1, &b->vertex_array);
    ctx->gl.BindVertexArray(b->vertex_array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, b->vertices.name);
    ctx->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, b->indices.name);
    ctx->gl.EnableVertexAttribArray(0);
    ctx->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, stride, NULL);
    if (b->source) {
        ctx->gl.EnableVertexAttribArray(1);
        ctx->gl.VertexAttribPointer(1, 3, GLBK_GL_FLOAT, 0, stride, (const void *)(size_t)12);
    }
    ctx->gl.BindVertexArray((uint32_t)array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, (uint32_t)buffer);
    return glbk__leave(ctx);
}

/* Checks a mesh as sfield_build does. */
static glbk_result glbk__sfield_check_mesh(const glbk_context *ctx, const char *function,
                                           const sfield_mesh *m)
{
    const size_t corners = glbk__sfield_mesh_corners(m);
    const char *count = m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count";
    glbk_sfield__logger log;
    size_t i;

    if (!m->positions) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.indices",
                            "and mesh.indices16 are both given");
    if (m->mask_fn)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.mask_fn",
                            "is set: the GPU cannot call it, and draw_fn draws masks");
    if (!glbk_sfield__stride_valid(m->vertex_stride, 12))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "mesh.vertex_stride",
                                  (double)m->vertex_stride, "0, or a multiple of 4 of at least 12");
    if (!corners || corners % 3)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, count, (double)corners,
                                  "a multiple of 3, > 0");
    if (corners > 0x7fffffffu)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, count, (double)corners, "below 2^31");
    if (m->vertex_count > 0xffffffffu)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "mesh.vertex_count", (double)m->vertex_count,
                                  "below 2^32");
    log.log = ctx->system.log;
    log.user = ctx->system.user;
    log.function = function;
    for (i = 0; i < corners; i++) {
        const uint32_t index = glbk__sfield_mesh_index(m, i);
        if (index < m->vertex_count) continue;
        glbk_sfield__log_index(&log, "mesh", i, index, m->vertex_count);
        return GLBK_ERR_INPUT;
    }
    return GLBK_OK;
}

/* Checks and uploads the mesh of a builder. */
static glbk_result glbk__sfield_take_mesh(glbk_context *ctx, const char *function,
                                          const glbk_sfield_builder_desc *d, glbk_sfield_builder *b)
{
    glbk_result result = glbk__sfield_check_mesh(ctx, function, d->mesh);
    glbk_sfield__message name;
    size_t i;

    if (result != GLBK_OK) return result;
    for (i = 0; d->source && i < glbk__sfield_mesh_corners(d->mesh); i++)
        if (!(d->radiance[i] >= 0 && d->radiance[i] <= 1e18f))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "desc.radiance", i, ""),
                                      (double)d->radiance[i], "0..1e18");
    if (!glbk__sfield_fit(d->mesh, b))
        return glbk__refuse(ctx, GLBK_ERR_INPUT, function, "mesh", "has no triangle that can be used");
    result = glbk__sfield_upload_mesh(ctx, d, b);
    return result == GLBK_OK ? glbk__sfield_vertex_array(ctx, b) : result;
}

/* Returns where texel (face, x, y) of a cube stands in the order of shadowfield.h. */
static uint32_t glbk__sfield_morton(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
{
    uint32_t morton = 0, bit;
    for (bit = 0; bit < 6; bit++) morton |= (x >> bit & 1u) << 2 * bit | (y >> bit & 1u) << (2 * bit + 1);
    return face * side * side + morton;
}

/* Uploads the integrals of the basis over each texel (sfield_cube_basis): groups of four coefficients, each
   with all texels in rows as the cubes have them. */
static glbk_result glbk__sfield_upload_basis(glbk_context *ctx, glbk_sfield_builder *b)
{
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint32_t n = b->bands * b->bands, side = b->side, cells = 6 * side * side;
    float *table = (float *)glbk_sfield__alloc_array(&memory, (size_t)cells * b->groups, 16),
          of[SFIELD_MAX_COEFS];
    uint32_t face, x, y, k;
    glbk_result result;

    if (!table) return GLBK_ERR_ALLOC;
    memset(table, 0, (size_t)cells * b->groups * 16);
    for (y = 0; y < side; y++)
        for (face = 0; face < 6; face++)
            for (x = 0; x < side; x++) {
                size_t at = (size_t)y * 6 * side + face * side + x;
                (void)sfield_cube_basis(b->bands, side, glbk__sfield_morton(side, face, x, y), of);
                for (k = 0; k < n; k++) table[4 * (at + (size_t)(k / 4) * cells) + k % 4] = of[k];
            }
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, table, (size_t)cells * b->groups, &b->basis);
    glbk_sfield__free(&memory, table);
    return result;
}

/* Makes the textures that a builder draws to. */
static glbk_result glbk__sfield_canvases(glbk_context *ctx, glbk_sfield_builder *b)
{
    const uint32_t size = !b->source && ctx->max_side >= 2048 ? 2048u : 1024u, channels = b->source ? 3 : 1;
    glbk_texture_desc depth;
    glbk_result result = GLBK_OK;

    memset(&depth, 0, sizeof depth);
    depth.format = GLBK_FORMAT_DEPTH32F;
    depth.width = depth.height = b->height = size;
    if (b->source) result = glbk_texture_create(ctx, &depth, &b->depth);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, b->source ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_R8UI, size, size,
                              b->source ? &b->depth : NULL, &b->seen, &b->seen_target);
    b->batch = (ctx->max_side >= 2048 ? 2048 : 1024) / b->side;
    b->batch = b->batch < GLBK__SFIELD_BATCH ? b->batch : (uint32_t)GLBK__SFIELD_BATCH;
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, 6 * b->side / (b->source ? 1 : 4),
                              b->batch * b->side, NULL, &b->cube, &b->cube_target);
    if (result == GLBK_OK && b->bands)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, b->groups * channels, b->batch, NULL, &b->coefs,
                              &b->coef_target);
    return result;
}

/* Checks a desc and copies it into the builder, with the defaults of sfield_desc. */
static glbk_result glbk__sfield_read_builder(const glbk_context *ctx, const char *function,
                                             const glbk_sfield_builder_desc *d, glbk_sfield_builder *b)
{
    const glbk_result bad = GLBK_ERR_DESC;
    sfield_desc f;
    int haar;

    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    memset(&f, 0, sizeof f);
    if (d->field) f = *d->field;
    haar = f.basis == SFIELD_BASIS_HAAR;
    if ((uint32_t)f.basis > SFIELD_BASIS_HAAR)
        return glbk__refuse_range(ctx, bad, function, "desc.field->basis", (double)f.basis, 0,
                                  SFIELD_BASIS_HAAR);
    if (f.bands > SFIELD_MAX_BANDS)
        return glbk__refuse_range(ctx, bad, function, "desc.field->bands", f.bands, 0, SFIELD_MAX_BANDS);
    if (f.cube_side && (f.cube_side < 4 || f.cube_side > 64 || (f.cube_side & (f.cube_side - 1))))
        return glbk__refuse_value(ctx, bad, function, "desc.field->cube_side", f.cube_side,
                                  "0 or a power of two of 4..64");
    if (!d->mesh && !d->draw_fn)
        return glbk__refuse(ctx, bad, function, "desc.mesh", "is NULL, like desc.draw_fn");
    if (d->mesh && d->source && !d->radiance)
        return glbk__refuse(ctx, bad, function, "desc.radiance", "is NULL");
    if (d->mesh && d->source && f.frame_count > 1)
        return glbk__refuse_value(ctx, bad, function, "desc.field->frame_count", f.frame_count,
                                  "0 or 1 with a mesh: other frames are drawn by draw_fn");
    b->side = f.cube_side ? f.cube_side : haar ? 32 : 16;
    b->bands = haar ? 0 : f.bands ? f.bands : 4;
    b->groups = (b->bands * b->bands + 3) / 4;
    b->source = d->source != 0;
    b->draw_fn = d->mesh ? NULL : d->draw_fn;
    b->user = d->user;
    b->compute = ctx->compute;
    return GLBK_OK;
}

/* Compiles the program that draws what a builder sees; the library draws a mesh with attributes of its
   own. */
static glbk_result glbk__sfield_see_program(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                            glbk_sfield_builder *b)
{
    static const char function[] = "glbk_sfield_builder_create";
    const uint32_t radiance = d->radiance_attribute && !d->mesh ? d->radiance_attribute : 1;
    char more[60];
    glbk_attributes at;
    glbk__sink sink;
    glbk_result result = glbk__take_attributes(ctx, function, &d->attributes, &at);

    if (result != GLBK_OK) return result;
    if (radiance > 15)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.radiance_attribute", radiance, 0, 15);
    if (d->mesh) {
        memset(&at, 0, sizeof at);
        at.normal = at.uv = at.tangent = -1;
    }
    if (b->source && !at.vertex && (uint32_t)at.position == radiance)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.radiance_attribute", radiance,
                                  "other than desc.attributes.position");
    sink.out = more;
    sink.bytes = sizeof more;
    sink.used = 0;
    glbk__append_text(&sink, b->source ? "SFIELD_SOURCE=1" : "SFIELD_SOURCE=0");
    glbk__append_text(&sink, " GLBK_PLACE SFIELD_RADIANCE=");
    glbk__sfield_number(&sink, radiance);
    more[sink.used] = 0;
    return glbk__drawing_program(ctx, glbk_sfield_part(), "sfield_see.frag", &at, more, &b->see);
}

/* Compiles the programs of a builder. */
static glbk_result glbk__sfield_builder_programs(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                                 glbk_sfield_builder *b)
{
    char defines[] = "SFIELD_SOURCE=0 SFIELD_BANDS=0";
    glbk_result result = glbk__sfield_see_program(ctx, d, b);

    defines[14] = b->source ? '1' : '0';
    defines[29] = (char)('0' + b->bands);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_sfield_part(),
                                      b->compute ? "sfield_sum.comp" : "sfield_sum.frag", defines, &b->sum);
    if (result == GLBK_OK && b->bands)
        result = glbk__program_create(ctx, glbk_sfield_part(),
                                      b->compute ? "sfield_project.comp" : "sfield_project.frag", defines,
                                      &b->project);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                                glbk_sfield_builder *out)
{
    const glbk_texture *last;
    glbk_sfield__allocator memory;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__sfield_read_builder(ctx, __func__, d, out);
    if (result == GLBK_OK && d->mesh) result = glbk__sfield_take_mesh(ctx, __func__, d, out);
    if (result == GLBK_OK && out->bands) result = glbk__sfield_upload_basis(ctx, out);
    if (result == GLBK_OK) result = glbk__sfield_canvases(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_views), NULL, &out->block);
    if (result == GLBK_OK) result = glbk__sfield_builder_programs(ctx, d, out);
    if (result == GLBK_OK) {
        last = out->bands ? &out->coefs : &out->cube;
        memory = glbk_sfield__memory(ctx);
        out->views = (glbk_sfield_views *)glbk_sfield__alloc(&memory, sizeof *out->views);
        out->words = (uint32_t *)glbk_sfield__alloc_array(&memory, (size_t)last->width * last->height, 16);
        if (!out->views || !out->words) result = GLBK_ERR_ALLOC;
    }
    if (result != GLBK_OK) glbk_sfield_builder_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *b)
{
    if (!b) return;
    if (ctx && !ctx->lost && b->vertex_array) ctx->gl.DeleteVertexArrays(1, &b->vertex_array);
    glbk_buffer_free(ctx, &b->vertices);
    glbk_buffer_free(ctx, &b->indices);
    glbk_buffer_free(ctx, &b->block);
    glbk_target_free(ctx, &b->seen_target);
    glbk_target_free(ctx, &b->cube_target);
    glbk_target_free(ctx, &b->coef_target);
    glbk_texture_free(ctx, &b->seen);
    glbk_texture_free(ctx, &b->depth);
    glbk_texture_free(ctx, &b->cube);
    glbk_texture_free(ctx, &b->coefs);
    glbk_texture_free(ctx, &b->basis);
    glbk_program_free(ctx, &b->see);
    glbk_program_free(ctx, &b->sum);
    glbk_program_free(ctx, &b->project);
    if (ctx) {
        glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
        glbk_sfield__free(&memory, b->views);
        glbk_sfield__free(&memory, b->words);
    }
    memset(b, 0, sizeof *b);
}
