/* ---- mesh ---- */

static const uint32_t *lsamp__corners(const lsamp_mesh *m, size_t triangle, uint32_t *scratch)
{
    int k;
    if (m->indices) return m->indices + 3 * triangle;
    for (k = 0; m->indices16 && k < 3; k++) scratch[k] = m->indices16[3 * triangle + (size_t)k];
    if (m->indices16) return scratch;
    scratch[0] = (uint32_t)(3 * triangle);
    scratch[1] = scratch[0] + 1;
    scratch[2] = scratch[0] + 2;
    return scratch;
}

static lsamp__v3 lsamp__vertex(const lsamp_mesh *m, uint32_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    float p[3];
    memcpy(p, (const char *)m->positions + stride * i, sizeof p);
    return lsamp__v3_load(p);
}

static size_t lsamp__corner_count(const lsamp_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static size_t lsamp__triangle_count(const lsamp_mesh *m) { return lsamp__corner_count(m) / 3; }

/* Logs that a field of the mesh cannot be used, and returns 0. log may be NULL, here and below. */
static int lsamp__mesh_refuse(const lsamp__logger *log, const char *field, const char *text)
{
    if (log) lsamp__log_text(log, field, text);
    return 0;
}

static int lsamp__mesh_valid(const lsamp_mesh *m, const lsamp__logger *log)
{
    size_t i, count;
    uint32_t index;
    if (!m) return lsamp__mesh_refuse(log, "desc.mesh", "is NULL");
    if (!m->positions) return lsamp__mesh_refuse(log, "desc.mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return lsamp__mesh_refuse(log, "desc.mesh.indices16", "is set beside indices");
    count = lsamp__corner_count(m);
    if (!m->vertex_count || m->vertex_count > 0x7fffffffu) {
        if (log) lsamp__log_value(log, "desc.mesh.vertex_count", (double)m->vertex_count, "1..2^31 - 1");
        return 0;
    }
    if (!lsamp__stride_valid(m->vertex_stride, 12)) {
        if (log)
            lsamp__log_value(log, "desc.mesh.vertex_stride", (double)m->vertex_stride,
                             "0 or a multiple of 4 from 12 on");
        return 0;
    }
    if (count == 0 || count % 3 || count > 0x7fffffffu) {
        if (log)
            lsamp__log_value(log,
                             m->indices || m->indices16 ? "desc.mesh.index_count" : "desc.mesh.vertex_count",
                             (double)count, "a multiple of 3, 3..2^31 - 1");
        return 0;
    }
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        index = m->indices ? m->indices[i] : m->indices16[i];
        if (index < m->vertex_count) continue;
        if (log) lsamp__log_index(log, "desc.mesh", i, index, m->vertex_count);
        return 0;
    }
    return 1;
}
