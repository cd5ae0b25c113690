/* ---- building: the mesh, its bounding sphere and its inscribed one ---- */

static const float *sfield__vertex(const sfield_mesh *m, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)m->positions + i * stride);
}

static size_t sfield__mesh_corners(const sfield_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t sfield__mesh_index(const sfield_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

/* Checks counts, strides and indices. What is wrong goes to the log. */
static sfield_result sfield__check_mesh(const sfield__build *b, const sfield_mesh *m)
{
    const size_t corners = sfield__mesh_corners(m);
    const char *count = m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count";
    size_t i;
    if (!m->positions) return sfield__fail(&b->log, SFIELD_ERR_ARGUMENT, "mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return sfield__fail(&b->log, SFIELD_ERR_ARGUMENT, "mesh", "has indices and indices16");
    if (!sfield__check_value(&b->log, sfield__stride_valid(m->vertex_stride, 12), "mesh.vertex_stride",
                             (double)m->vertex_stride, "0, or a multiple of 4 of at least 12") ||
        !sfield__check_value(&b->log, corners && corners % 3 == 0, count, (double)corners,
                             "a multiple of 3, > 0"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&b->log, corners / 3 <= 0x7ffffffeu, count, (double)corners,
                             "3 (2^31 - 2) or less") ||
        !sfield__check_value(&b->log, m->vertex_count <= 0xffffffffu, "mesh.vertex_count",
                             (double)m->vertex_count, "below 2^32"))
        return SFIELD_ERR_LIMIT;
    for (i = 0; i < corners; i++) {
        const uint32_t index = sfield__mesh_index(m, i);
        if (index < m->vertex_count) continue;
        sfield__log_index(&b->log, "mesh", i, index, m->vertex_count);
        return SFIELD_ERR_INPUT;
    }
    return SFIELD_OK;
}

/* Keeps the triangles that can be used. Returns 0 if there is no memory. */
static int sfield__take_triangles(sfield__build *b, const sfield_mesh *m, size_t stride, size_t count)
{
    size_t t;
    b->index = (uint32_t *)sfield__hold_memory(b, 3 * count, sizeof *b->index);
    b->original = (uint32_t *)sfield__hold_memory(b, count, sizeof *b->original);
    if (!b->index || !b->original) return 0;
    for (t = 0; t < count; t++) {
        uint32_t i[3], k, good = 1;
        for (k = 0; k < 3; k++) {
            i[k] = sfield__mesh_index(m, 3 * t + k);
            if (good) {
                sfield__v3 p = sfield__v3_load(sfield__vertex(m, stride, i[k]));
                good = sfield__v3_finite(p) && fabsf(p.x) < 1e18f && fabsf(p.y) < 1e18f && fabsf(p.z) < 1e18f;
            }
        }
        for (k = 0; k < 3 && good; k++)
            good =
                memcmp(sfield__vertex(m, stride, i[k]), sfield__vertex(m, stride, i[(k + 1) % 3]), 12) != 0;
        if (!good) {
            b->skipped++;
            continue;
        }
        memcpy(b->index + 3 * b->triangles, i, sizeof i);
        b->original[b->triangles++] = (uint32_t)t;
    }
    return 1;
}

static void sfield__fit_sphere(sfield__build *b, const sfield_mesh *m, size_t stride)
{
    sfield__v3 low = sfield__v3_make(0, 0, 0), high = low, c;
    size_t i;
    float r2 = 0;
    for (i = 0; i < 3 * b->triangles; i++) {
        sfield__v3 p = sfield__v3_load(sfield__vertex(m, stride, b->index[i]));
        low = i ? sfield__v3_min(low, p) : p;
        high = i ? sfield__v3_max(high, p) : p;
    }
    c = sfield__v3_add(sfield__v3_scale(low, 0.5f), sfield__v3_scale(high, 0.5f));
    sfield__v3_store(b->h.center, c);
    for (i = 0; i < 3 * b->triangles; i++) {
        sfield__v3 p = sfield__v3_sub(sfield__v3_load(sfield__vertex(m, stride, b->index[i])), c);
        r2 = sfield__v3_dot(p, p) > r2 ? sfield__v3_dot(p, p) : r2;
    }
    b->h.radius = sqrtf(r2);
}

/* Returns whether the bounding sphere holds what is drawn, to a thousandth. Horizons, cones and the tail
   beyond the last shell rely on the sphere; fields of points have none of them. */
static int sfield__is_bounded(const sfield__build *b)
{
    size_t i;
    for (i = 0; i < 3 * b->triangles && b->h.kind != SFIELD__KIND_SELF; i++) {
        const sfield__v3 p = sfield__v3_load(b->position + 3 * (size_t)b->index[i]);
        if (sfield__v3_dot(p, p) * (0.999f * 0.999f) > 1) return 0;
    }
    return 1;
}

/* Puts the corners of all triangles into planes, for kernels. Returns 0 if there is no memory. */
static int sfield__take_corners(sfield__build *b)
{
    size_t t, k, c;
    b->corner_room = (b->triangles + 15) / 16 * 16;
    b->corner = (float *)sfield__hold_memory(b, b->corner_room, 9 * sizeof *b->corner);
    if (!b->corner) return 0;
    memset(b->corner, 0, 9 * b->corner_room * sizeof *b->corner);
    for (t = 0; t < b->triangles; t++)
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++)
                b->corner[(3 * k + c) * b->corner_room + t] =
                    b->position[3 * (size_t)b->index[3 * t + k] + c];
    return 1;
}

static sfield_result sfield__take_mesh(sfield__build *b, const sfield_mesh *m)
{
    const size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    const sfield_result result = sfield__check_mesh(b, m);
    size_t i, k;
    if (result != SFIELD_OK) return result;
    if (!sfield__take_triangles(b, m, stride, sfield__mesh_corners(m) / 3)) return SFIELD_ERR_ALLOC;
    if (!b->triangles)
        return sfield__fail(&b->log, SFIELD_ERR_INPUT, "mesh", "has no triangle that can be used");
    if (b->desc.radius == 0) sfield__fit_sphere(b, m, stride);
    if (!sfield__check_value(&b->log, sfield__in(b->h.radius, 1e-18f, 1e18f), "the radius of mesh",
                      (double)b->h.radius, "1e-18..1e18"))
        return SFIELD_ERR_INPUT;
    b->mask_fn = m->mask_fn;
    b->mask_user = m->user;
    b->vertices = m->vertex_count;
    b->position = (float *)sfield__hold_memory(b, 3 * b->vertices, sizeof *b->position);
    if (!b->position) return SFIELD_ERR_ALLOC;
    for (i = 0; i < b->vertices; i++)
        for (k = 0; k < 3; k++) {
            float x = (sfield__vertex(m, stride, i)[k] - b->h.center[k]) / b->h.radius;
            b->position[3 * i + k] = sfield__finite(x) ? x : 0;
        }
    if (!sfield__is_bounded(b))
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "desc.center and radius", "do not hold the mesh");
    return sfield__take_corners(b) ? SFIELD_OK : SFIELD_ERR_ALLOC;
}

/* Returns the distance from the origin to the nearest point of a triangle. */
static float sfield__measure_triangle(const float *const *corner)
{
    sfield__v3 p[3], n;
    float best = 3e38f, nn;
    int i, inside = 1;
    for (i = 0; i < 3; i++) p[i] = sfield__v3_load(corner[i]);
    n = sfield__v3_cross(sfield__v3_sub(p[1], p[0]), sfield__v3_sub(p[2], p[0]));
    nn = sfield__v3_dot(n, n);
    for (i = 0; i < 3; i++) {
        sfield__v3 a = p[i], e = sfield__v3_sub(p[(i + 1) % 3], a);
        float ee = sfield__v3_dot(e, e), t = ee > 0 ? -sfield__v3_dot(a, e) / ee : 0, d;
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        d = sfield__v3_length(sfield__v3_madd(a, e, t));
        best = d < best ? d : best;
        inside = inside && sfield__v3_dot(sfield__v3_cross(e, sfield__v3_scale(a, -1)), n) >= 0;
    }
    return inside && nn > 0 ? fabsf(sfield__v3_dot(n, p[0])) / sqrtf(nn) : best;
}

/* Returns the radius of a sphere about the center that the mesh closes off: everything is hidden from there,
   and no triangle is nearer. 0 if there is none. */
static float sfield__find_inscribed(sfield__build *b)
{
    const float eye[3] = { 0, 0, 0 };
    float nearest = 1;
    size_t t;
    uint32_t i;
    sfield__view_from(b, &b->view[0], eye);
    for (i = 0; i < b->cells; i++)
        if (b->view[0].texel[i] < 1) return 0;
    for (t = 0; t < b->triangles; t++) {
        const float *c[3];
        float d;
        for (i = 0; i < 3; i++) c[i] = b->position + 3 * (size_t)b->index[3 * t + i];
        d = sfield__measure_triangle(c);
        nearest = d < nearest ? d : nearest;
    }
    return nearest * b->h.radius;
}
