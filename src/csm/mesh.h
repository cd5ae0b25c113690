/* ---- mesh: checked, normalised triangles ---- */

static const uint32_t *cohsm__corners(const cohsm_mesh *m, size_t triangle, uint32_t *scratch)
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

static cohsm__v3 cohsm__vertex(const cohsm_mesh *m, uint32_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    float p[3];
    memcpy(p, (const char *)m->positions + stride * i, sizeof p);
    return cohsm__v3_load(p);
}

static size_t cohsm__corner_count(const cohsm_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static size_t cohsm__triangle_count(const cohsm_mesh *m) { return cohsm__corner_count(m) / 3; }

static cohsm_result cohsm__check_mesh(const cohsm_mesh *m, const cohsm__logger *log)
{
    size_t i, count;
    uint32_t index;
    cohsm_result result = COHSM_ERR_ARGUMENT;

    count = m ? cohsm__corner_count(m) : 0;
    if (!m) cohsm__log_text(log, "mesh", "is NULL");
    else if (!m->positions) cohsm__log_text(log, "mesh.positions", "is NULL");
    else if (!m->vertex_count) cohsm__log_value(log, "mesh.vertex_count", 0.0, "1 or more");
    else if (m->indices && m->indices16) cohsm__log_text(log, "mesh.indices16", "is set beside indices");
    else if (!cohsm__stride_valid(m->vertex_stride, 12))
        cohsm__log_value(log, "mesh.vertex_stride", (double)m->vertex_stride,
                         "0, or 12 or more and a multiple of 4");
    else if (m->vertex_count > 0x7fffffffu || count > 0x7fffffffu) {
        cohsm__log_value(log, m->vertex_count > 0x7fffffffu ? "mesh.vertex_count" : "mesh.index_count",
                         (double)(m->vertex_count > 0x7fffffffu ? m->vertex_count : count), "below 2^31");
        result = COHSM_ERR_LIMIT;
    } else if (count == 0 || count % 3)
        cohsm__log_value(log, m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count",
                         (double)count, "a multiple of 3, above 0");
    else result = COHSM_OK;
    if (result != COHSM_OK || (!m->indices && !m->indices16)) return result;
    for (i = 0; i < count; i++) {
        index = m->indices ? m->indices[i] : m->indices16[i];
        if (index < m->vertex_count) continue;
        cohsm__log_index(log, "mesh", i, index, m->vertex_count);
        return COHSM_ERR_INPUT;
    }
    return COHSM_OK;
}

/* Says whether a comes before b by x, then y, then z. Copies of a triangle whose corners are sorted so
   compare equal whatever their winding. */
static int cohsm__comes_before(cohsm__v3 a, cohsm__v3 b)
{
    if (a.x < b.x || a.x > b.x) return a.x < b.x;
    if (a.y < b.y || a.y > b.y) return a.y < b.y;
    return a.z < b.z;
}

static void cohsm__sort3(cohsm__v3 *p)
{
    cohsm__v3 t;
    int i;
    for (i = 0; i < 3; i++)
        if (cohsm__comes_before(p[i == 1 ? 2 : 1], p[i == 1 ? 1 : 0])) {
            t = p[i == 1 ? 1 : 0];
            p[i == 1 ? 1 : 0] = p[i == 1 ? 2 : 1];
            p[i == 1 ? 2 : 1] = t;
        }
}

static int cohsm__same_corner(cohsm__v3 a, cohsm__v3 b)
{
    return !cohsm__comes_before(a, b) && !cohsm__comes_before(b, a);
}

static uint32_t cohsm__hash_corners(const cohsm__v3 *p)
{
    uint32_t h = 0, bits, i, k;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++) {
            float f = (k == 0 ? p[i].x : k == 1 ? p[i].y : p[i].z) + 0.0f;   /* -0 becomes 0 */
            memcpy(&bits, &f, sizeof bits);
            h = cohsm__hash_combine(h, bits);
        }
    return h;
}

/* Sets used[t] to 1 for the triangles that are rendered, which are finite, have three different corners, and
   are the first of their copies. A copy would put a second depth beside an equal first one, so that hardly
   any two views could share a segment. */
static cohsm_result cohsm__select_triangles(const cohsm_mesh *mesh, uint8_t *used, cohsm__counted_heap *heap,
                                            cohsm_stats *stats)
{
    size_t count = cohsm__triangle_count(mesh), slots = 16, t, s;
    uint32_t *table, scratch[3], scratch2[3];
    int k, copy;

    while (slots < 2 * count) slots *= 2;
    table = (uint32_t *)cohsm__heap_alloc(heap, slots, sizeof *table);
    if (!table) return COHSM_ERR_ALLOC;
    memset(table, 0, slots * sizeof *table);
    for (t = 0; t < count; t++) {
        const uint32_t *c = cohsm__corners(mesh, t, scratch);
        cohsm__v3 p[3], q[3];
        for (k = 0; k < 3; k++) p[k] = cohsm__vertex(mesh, c[k]);
        used[t] = 0;
        if (!cohsm__v3_finite(p[0]) || !cohsm__v3_finite(p[1]) || !cohsm__v3_finite(p[2]) ||
            cohsm__same_corner(p[0], p[1]) || cohsm__same_corner(p[1], p[2]) ||
            cohsm__same_corner(p[2], p[0])) {
            stats->skipped_triangles++;
            continue;
        }
        cohsm__sort3(p);
        for (s = cohsm__hash_corners(p) & (slots - 1), copy = 0; table[s] && !copy;
             s = (s + 1) & (slots - 1)) {
            c = cohsm__corners(mesh, table[s] - 1u, scratch2);
            for (k = 0; k < 3; k++) q[k] = cohsm__vertex(mesh, c[k]);
            cohsm__sort3(q);
            copy = cohsm__same_corner(p[0], q[0]) && cohsm__same_corner(p[1], q[1]) &&
                   cohsm__same_corner(p[2], q[2]);
        }
        if (copy) {
            stats->duplicate_triangles++;
            continue;
        }
        table[s] = (uint32_t)t + 1u;
        used[t] = 1;
        stats->triangles++;
    }
    cohsm__heap_free(heap, table, slots, sizeof *table);
    return stats->triangles ? COHSM_OK : COHSM_ERR_INPUT;
}
