/* ---- mesh: corners of a mesh that emits, and its checks ---- */

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

/* Logs what a field of the mesh is, and returns the result. log may be NULL. */
static lsamp_result lsamp__mesh_refuse(const lsamp__logger *log, lsamp_result result, const char *field,
                                       const char *text)
{
    if (log) lsamp__log_text(log, field, text);
    return result;
}

/* Logs that a number of the mesh is out of its range, and returns the result. log may be NULL. */
static lsamp_result lsamp__mesh_refuse_value(const lsamp__logger *log, lsamp_result result, const char *field,
                                             size_t value, const char *wanted)
{
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return result;
}

static lsamp_result lsamp__indices_check(const lsamp_mesh *m, size_t count, const lsamp__logger *log)
{
    size_t i;
    uint32_t index;
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        index = m->indices ? m->indices[i] : m->indices16[i];
        if (index < m->vertex_count) continue;
        if (log) lsamp__log_index(log, "desc.mesh", i, index, m->vertex_count);
        return LSAMP_ERR_INPUT;
    }
    return LSAMP_OK;
}

static lsamp_result lsamp__mesh_check(const lsamp_mesh *m, const lsamp__logger *log)
{
    const lsamp_result bad = LSAMP_ERR_ARGUMENT;
    const char *name;
    size_t count;
    if (!m) return lsamp__mesh_refuse(log, LSAMP_ERR_DESC, "desc.mesh", "is NULL");
    if (!m->positions) return lsamp__mesh_refuse(log, bad, "desc.mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return lsamp__mesh_refuse(log, bad, "desc.mesh.indices16", "is set beside indices");
    if (!lsamp__stride_valid(m->vertex_stride, 12))
        return lsamp__mesh_refuse_value(log, bad, "desc.mesh.vertex_stride", m->vertex_stride,
                                        "0 or a multiple of 4 from 12 on");
    if (!m->vertex_count || m->vertex_count > 0x7fffffffu)
        return lsamp__mesh_refuse_value(log, m->vertex_count ? LSAMP_ERR_LIMIT : bad,
                                        "desc.mesh.vertex_count", m->vertex_count, "1..2^31 - 1");
    name = m->indices || m->indices16 ? "desc.mesh.index_count" : "desc.mesh.vertex_count";
    count = lsamp__corner_count(m);
    if (count == 0 || count % 3)
        return lsamp__mesh_refuse_value(log, bad, name, count, "a multiple of 3, 3..2^31 - 1");
    if (count > 0x7fffffffu)
        return lsamp__mesh_refuse_value(log, LSAMP_ERR_LIMIT, name, count, "a multiple of 3, 3..2^31 - 1");
    return lsamp__indices_check(m, count, log);
}
