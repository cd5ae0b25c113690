/* ---- raster: triangles into a face ---- */

/* Triangles are drawn by homogeneous edge functions (Olano and Greer 1997). A corner is (x, y, w), where w is
   the depth in a perspective face and 1 for a sun. The ray (X, Y, 1) meets the triangle if three determinants
   have the same sign, and their shares are the weights of the corners. Nothing has to be clipped. Both
   triangles at an edge compute it in double from the same floats, so that there are no cracks. */
typedef struct rsm__corner {
    double x, y, w, z;
} rsm__corner;

/* Columns x0..x1 and rows y0..y1 of a face, ends included; x0 > x1 if there are none. */
typedef struct rsm__box { uint16_t x0, y0, x1, y1; } rsm__box;

typedef struct rsm__raster {
    rsm_map        *map;
    const rsm_mesh *meshes;
    size_t          mesh_count, triangles;
    uint32_t        face;
    rsm__box       *boxes;         /* of each triangle on this face */
    uint32_t       *winners;       /* for each texel the number + 1 of the triangle that is nearest; 0: none
                                      */
    rsm__v3         right, up, axis;    /* of this face */
} rsm__raster;

enum {
    RSM__CHUNK = 4096,             /* triangles whose boxes one task finds */
    RSM__BAND = 16                 /* rows of a face that one task draws */
};

static inline size_t rsm__mesh_triangles(const rsm_mesh *m)
{
    return (m->indices || m->indices16 ? m->index_count : m->vertex_count) / 3;
}

/* Returns corner k of a triangle, in the world. */
static inline rsm__v3 rsm__mesh_corner(const rsm_mesh *m, size_t triangle, int k)
{
    size_t i = 3 * triangle + (size_t)k;
    const float *p, *t = m->transform;
    if (m->indices) i = m->indices[i];
    else if (m->indices16) i = m->indices16[i];
    p = rsm__element_at(m->positions, rsm__stride_or(m->vertex_stride, 12), i);
    if (!t) return rsm__v3_load(p);
    return rsm__v3_make(t[0] * p[0] + t[4] * p[1] + t[8] * p[2] + t[12],
                        t[1] * p[0] + t[5] * p[1] + t[9] * p[2] + t[13],
                        t[2] * p[0] + t[6] * p[1] + t[10] * p[2] + t[14]);
}

/* Returns the mesh that holds triangle `number` of all meshes, and writes its number within the mesh. */
static inline const rsm_mesh *rsm__mesh_of(const rsm__raster *r, size_t number, size_t *triangle)
{
    const rsm_mesh *m = r->meshes;
    while (number >= rsm__mesh_triangles(m)) number -= rsm__mesh_triangles(m++);
    *triangle = number;
    return m;
}

static inline rsm__corner rsm__project_corner(const rsm__raster *r, rsm__v3 p)
{
    const float *o = r->map->desc.light.position;
    double x = (double)p.x - (double)o[0], y = (double)p.y - (double)o[1], z = (double)p.z - (double)o[2];
    double e = (double)r->map->extent;
    rsm__corner c;
    c.x = x * (double)r->right.x + y * (double)r->right.y + z * (double)r->right.z;
    c.y = x * (double)r->up.x + y * (double)r->up.y + z * (double)r->up.z;
    c.z = x * (double)r->axis.x + y * (double)r->axis.y + z * (double)r->axis.z;
    c.w = 1.0;
    if (rsm__is_sun(r->map)) {
        c.x /= e;
        c.y /= e;
    } else c.w = c.z * e;
    return c;
}

static inline void rsm__widen_box(double box[4], double x, double y)
{
    if (x < box[0]) box[0] = x;
    if (y < box[1]) box[1] = y;
    if (x > box[2]) box[2] = x;
    if (y > box[3]) box[3] = y;
}

/* Returns the box of texels whose centres may lie in the triangle. In place of a corner before the near plane
   count the points where the corner's edges cross that plane. */
static inline rsm__box rsm__bound_triangle(const rsm__raster *r, const rsm__corner c[3])
{
    double box[4] = { 1e30, 1e30, -1e30, -1e30 }, near_z = (double)r->map->desc.light.near_depth,
           size = r->map->side;
    rsm__box out = { 1, 0, 0, 0 };
    int k;
    if (rsm__is_sun(r->map)) {
        for (k = 0; k < 3; k++) rsm__widen_box(box, c[k].x, c[k].y);
    } else
        for (k = 0; k < 3; k++) {
            const rsm__corner *p = &c[k], *q = &c[(k + 1) % 3];
            if (p->z >= near_z) rsm__widen_box(box, p->x / p->w, p->y / p->w);
            if ((p->z >= near_z) != (q->z >= near_z)) {
                double t = (near_z - p->z) / (q->z - p->z), w = near_z * (double)r->map->extent;
                rsm__widen_box(box, (p->x + t * (q->x - p->x)) / w, (p->y + t * (q->y - p->y)) / w);
            }
        }
    for (k = 0; k < 4; k++) { /* a hair wider than the triangle, since the edge functions decide */
        double t = (box[k] + 1.0) * 0.5 * size - 0.5;
        t = k < 2 ? ceil(t - 1e-6 * size) : floor(t + 1e-6 * size);
        box[k] = t < 0.0 && k < 2 ? 0.0 : t > size - 1.0 && k >= 2 ? size - 1.0 : t;
    }
    if (!(box[0] <= box[2] && box[1] <= box[3])) return out;
    out.x0 = (uint16_t)box[0];
    out.y0 = (uint16_t)box[1];
    out.x1 = (uint16_t)box[2];
    out.y1 = (uint16_t)box[3];
    return out;
}

/* Returns whether a triangle is drawn: its corners are usable and it has an area. */
static inline int rsm__corners_usable(const rsm__v3 p[3])
{
    rsm__v3 n = rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0]));
    return rsm__is_usable(p[0]) && rsm__is_usable(p[1]) && rsm__is_usable(p[2]) &&
           (n.x != 0.0f || n.y != 0.0f || n.z != 0.0f);
}

/* Finds the boxes of a chunk of triangles. */
static inline void rsm__bound_chunk(void *context, size_t chunk)
{
    rsm__raster *r = (rsm__raster *)context;
    size_t i, first = chunk * RSM__CHUNK, triangle,
              end = first + RSM__CHUNK < r->triangles ? first + RSM__CHUNK : r->triangles;
    const rsm_mesh *m = rsm__mesh_of(r, first, &triangle);
    for (i = first; i < end; i++, triangle++) {
        rsm__v3 p[3];
        rsm__corner c[3];
        int k;
        while (triangle >= rsm__mesh_triangles(m)) {
            m++;
            triangle = 0;
        }
        for (k = 0; k < 3; k++) p[k] = rsm__mesh_corner(m, triangle, k);
        r->boxes[i].x0 = 1;
        r->boxes[i].x1 = 0;
        if (!rsm__corners_usable(p)) continue;
        for (k = 0; k < 3; k++) c[k] = rsm__project_corner(r, p[k]);
        r->boxes[i] = rsm__bound_triangle(r, c);
    }
}

/* The edge functions of a triangle. Edge k at (x, y) is a[k] x + b[k] y + c[k], which is above 0 inside;
   points on the edge are inside if it is owned. */
typedef struct rsm__edges { double a[3], b[3], c[3], determinant; int owned[3]; } rsm__edges;

/* Makes the edge functions. Returns 0 for a triangle that is seen edge-on. */
static inline int rsm__edges_make(rsm__edges *e, const rsm__corner p[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        const rsm__corner *u = &p[(k + 1) % 3], *v = &p[(k + 2) % 3];
        e->a[k] = u->y * v->w - u->w * v->y;
        e->b[k] = u->w * v->x - u->x * v->w;
        e->c[k] = u->x * v->y - u->y * v->x;
    }
    e->determinant = p[0].x * e->a[0] + p[0].y * e->b[0] + p[0].w * e->c[0];
    for (k = 0; k < 3; k++) {
        if (e->determinant < 0.0) {
            e->a[k] = -e->a[k];
            e->b[k] = -e->b[k];
            e->c[k] = -e->c[k];
        }
        e->owned[k] = e->a[k] > 0.0 || (e->a[k] == 0.0 && e->b[k] > 0.0);
    }
    return e->determinant != 0.0;
}

/* Writes the weights of the corners at (x, y). Returns 0 if that lies outside of the triangle. */
static inline int rsm__find_weights(const rsm__edges *e, double x, double y, double w[3])
{
    double sum;
    int k;
    for (k = 0; k < 3; k++) {
        w[k] = e->a[k] * x + e->b[k] * y + e->c[k];
        if (!(w[k] > 0.0 || (w[k] == 0.0 && e->owned[k]))) return 0;
    }
    sum = w[0] + w[1] + w[2];
    if (!(sum > 0.0)) return 0;
    for (k = 0; k < 3; k++) w[k] /= sum;
    return 1;
}

/* Returns whether the mesh's mask has a hole there. */
static inline int rsm__is_hole(const rsm_mesh *m, size_t triangle, const double w[3])
{
    float weights[3] = { (float)w[0], (float)w[1], (float)w[2] };
    return m->mask_fn && !m->mask_fn(m->user, (uint32_t)triangle, weights);
}

/* Draws one triangle into the rows y0..y1 of the face: where it is nearest, its depth goes into the texel and
   its number among the winners. */
static inline void rsm__draw_triangle(const rsm__raster *r, const rsm_mesh *m, size_t triangle, size_t number,
                                      uint32_t y0, uint32_t y1)
{
    rsm__box box = r->boxes[number];
    double size = r->map->side, low = (double)r->map->desc.light.near_depth,
           high = (double)r->map->desc.light.far_depth;
    rsm__corner c[3];
    rsm__edges e;
    uint32_t x, y;
    int k;
    for (k = 0; k < 3; k++) c[k] = rsm__project_corner(r, rsm__mesh_corner(m, triangle, k));
    if (!rsm__edges_make(&e, c)) return;
    for (y = box.y0 > y0 ? box.y0 : y0; y <= box.y1 && y <= y1; y++)
        for (x = box.x0; x <= box.x1; x++) {
            size_t at = ((size_t)r->face * r->map->side + y) * r->map->side + x;
            double w[3], z;
            if (!rsm__find_weights(&e, (x + 0.5) * 2.0 / size - 1.0, (y + 0.5) * 2.0 / size - 1.0, w))
                continue;
            z = w[0] * c[0].z + w[1] * c[1].z + w[2] * c[2].z;
            if (!(z >= low && z <= high && (float)z < r->map->texels[at].depth) ||
                rsm__is_hole(m, triangle, w))
                continue;
            r->map->texels[at].depth = (float)z;
            r->winners[(size_t)y * r->map->side + x] = (uint32_t)number + 1u;
        }
}

/* Writes the mean of surface_fn over those of taps x taps points of the texel, in the triangle's plane, that
   are in no hole. */
static inline void rsm__mean_albedo(const rsm_mesh *m, size_t triangle, const rsm__edges *e, double x,
                                    double y, double h, float out[3])
{
    uint32_t taps = m->tap_side ? m->tap_side : 1, i, j, found = 0;
    float sum[3] = { 0, 0, 0 };
    int k;
    for (k = 0; k < 3; k++) out[k] = m->albedo[k];
    if (!m->surface_fn) return;
    for (j = 0; j < taps; j++)
        for (i = 0; i < taps; i++) {
            double s = x + h * ((2.0 * i + 1.0) / taps - 1.0), t = y + h * ((2.0 * j + 1.0) / taps - 1.0),
                   total = 0.0, w[3];
            float weights[3], albedo[3] = { 0, 0, 0 };
            for (k = 0; k < 3; k++) {
                w[k] = e->a[k] * s + e->b[k] * t + e->c[k];
                w[k] = w[k] > 0.0 ? w[k] : 0.0; /* a point beyond an edge is moved onto the edge */
                total += w[k];
            }
            for (k = 0; k < 3; k++) weights[k] = total > 0.0 ? (float)(w[k] / total) : 1.0f / 3.0f;
            if (m->mask_fn && !m->mask_fn(m->user, (uint32_t)triangle, weights)) continue;
            m->surface_fn(m->user, m, (uint32_t)triangle, weights, albedo);
            for (k = 0; k < 3; k++) sum[k] += albedo[k];
            found++;
        }
    for (k = 0; k < 3; k++) out[k] = found ? sum[k] / (float)found : 0.0f;
}

/* Fills in a texel of the triangle that won it. */
static inline void rsm__resolve_texel(const rsm__raster *r, uint32_t x, uint32_t y)
{
    uint32_t winner = r->winners[(size_t)y * r->map->side + x];
    double size = r->map->side, s = (x + 0.5) * 2.0 / size - 1.0, t = (y + 0.5) * 2.0 / size - 1.0, w[3];
    size_t triangle;
    const rsm_mesh *m;
    rsm__v3 p[3], normal, position;
    rsm__corner c[3];
    rsm__edges e;
    float albedo[3];
    int k;
    if (!winner) return;
    m = rsm__mesh_of(r, winner - 1u, &triangle);
    for (k = 0; k < 3; k++) {
        p[k] = rsm__mesh_corner(m, triangle, k);
        c[k] = rsm__project_corner(r, p[k]);
    }
    rsm__edges_make(&e, c);
    if (!rsm__find_weights(&e, s, t, w)) return;
    normal = rsm__v3_normalize(rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0])));
    position = rsm__v3_make((float)(w[0] * (double)p[0].x + w[1] * (double)p[1].x + w[2] * (double)p[2].x),
                            (float)(w[0] * (double)p[0].y + w[1] * (double)p[1].y + w[2] * (double)p[2].y),
                            (float)(w[0] * (double)p[0].z + w[1] * (double)p[1].z + w[2] * (double)p[2].z));
    if (rsm__v3_dot(normal, rsm__to_light(r->map, position)) < 0.0f) normal = rsm__v3_scale(normal, -1);
    rsm__mean_albedo(m, triangle, &e, s, t, 1.0 / size, albedo);
    rsm__texel_set(r->map, r->face, x, y, position, normal, albedo, m->material);
}

/* Draws all triangles into a band of rows, and fills in its texels. */
static inline void rsm__draw_band(void *context, size_t band)
{
    const rsm__raster *r = (const rsm__raster *)context;
    uint32_t y0 = (uint32_t)band * RSM__BAND, y1 = y0 + RSM__BAND - 1u, x, y;
    size_t number = 0, triangle, mesh;
    if (y1 >= r->map->side) y1 = r->map->side - 1u;
    for (mesh = 0; mesh < r->mesh_count; mesh++)
        for (triangle = 0; triangle < rsm__mesh_triangles(r->meshes + mesh); triangle++, number++) {
            rsm__box b = r->boxes[number];
            if (b.x0 <= b.x1 && b.y0 <= y1 && b.y1 >= y0)
                rsm__draw_triangle(r, r->meshes + mesh, triangle, number, y0, y1);
        }
    for (y = y0; y <= y1; y++)
        for (x = 0; x < r->map->side; x++) rsm__resolve_texel(r, x, y);
}

/* Writes the name of a mesh's field for the log, as in "meshes[2].positions". */
static inline const char *rsm__mesh_field(rsm__message *name, size_t number, const char *field)
{
    name->used = 0;
    rsm__message_text(name, "meshes[");
    rsm__message_count(name, number);
    rsm__message_text(name, "]");
    rsm__message_text(name, field);
    return name->text;
}

/* Logs that a field of a mesh is out of its range, and returns the result. */
static inline rsm_result rsm__refuse_mesh(const rsm__logger *log, rsm_result result, size_t number,
                                          const char *field, double value, const char *wanted)
{
    rsm__message name;
    rsm__log_value(log, rsm__mesh_field(&name, number, field), value, wanted);
    return result;
}

/* Logs that a field of a mesh is what the text says, and returns the result. */
static inline rsm_result rsm__refuse_mesh_text(const rsm__logger *log, rsm_result result, size_t number,
                                               const char *field, const char *text)
{
    rsm__message name;
    rsm__log_text(log, rsm__mesh_field(&name, number, field), text);
    return result;
}

/* Checks what must hold before the arrays of a mesh can be read. */
static inline rsm_result rsm__arrays_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const int indexed = m->indices || m->indices16;
    size_t count = indexed ? m->index_count : m->vertex_count;
    if (!m->positions && m->vertex_count)
        return rsm__refuse_mesh_text(log, RSM_ERR_ARGUMENT, number, ".positions", "is NULL");
    if (!rsm__stride_valid(m->vertex_stride, 12))
        return rsm__refuse_mesh(log, RSM_ERR_ARGUMENT, number, ".vertex_stride", (double)m->vertex_stride,
                                "0 or a multiple of 4 from 12 on");
    if (m->indices && m->indices16)
        return rsm__refuse_mesh_text(log, RSM_ERR_ARGUMENT, number, ".indices16", "is set beside indices");
    if (count % 3 != 0)
        return rsm__refuse_mesh(log, RSM_ERR_ARGUMENT, number, indexed ? ".index_count" : ".vertex_count",
                                (double)count, "a multiple of 3");
    return RSM_OK;
}

static inline rsm_result rsm__indices_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const int indexed = m->indices || m->indices16;
    size_t k, count = indexed ? m->index_count : m->vertex_count;
    rsm__message name;
    for (k = 0; indexed && k < count; k++) {
        uint32_t index = m->indices ? m->indices[k] : m->indices16[k];
        if (index < m->vertex_count) continue;
        rsm__log_index(log, rsm__mesh_field(&name, number, ""), k, index, m->vertex_count);
        return RSM_ERR_INPUT;
    }
    return RSM_OK;
}

static inline rsm_result rsm__mesh_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const rsm_result result = rsm__arrays_check(log, m, number);
    int k;
    if (result != RSM_OK) return result;
    if (m->tap_side > 16)
        return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".tap_side", m->tap_side, "0..16");
    for (k = 0; k < 3; k++)
        if (!(m->albedo[k] >= 0.0f && m->albedo[k] <= 1e6f))
            return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".albedo", (double)m->albedo[k], "0..1e6");
    for (k = 0; m->transform && k < 16; k++)
        if (!rsm__finite(m->transform[k]))
            return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".transform", (double)m->transform[k],
                                    "finite");
    return rsm__indices_check(log, m, number);
}

/* Checks all meshes, and counts their triangles and those that are skipped. */
static inline rsm_result rsm__meshes_check(const rsm__logger *log, rsm__raster *r, uint64_t *skipped)
{
    size_t i, triangle;
    int k;
    r->triangles = 0;
    for (i = 0; i < r->mesh_count; i++) {
        const rsm_mesh *m = r->meshes + i;
        size_t count = rsm__mesh_triangles(m);
        rsm_result result = rsm__mesh_check(log, m, i);
        if (result != RSM_OK) return result;
        if (count > 0xfffffffeu - r->triangles) {
            rsm__log_value(log, "the triangles of meshes", (double)r->triangles + (double)count,
                           "below 2^32 - 1");
            return RSM_ERR_LIMIT;
        }
        r->triangles += count;
        for (triangle = 0; triangle < count; triangle++) {
            rsm__v3 p[3];
            for (k = 0; k < 3; k++) p[k] = rsm__mesh_corner(m, triangle, k);
            *skipped += !rsm__corners_usable(p);
        }
    }
    return RSM_OK;
}

static inline rsm_result rsm__raster_faces(rsm__raster *r)
{
    const rsm_system *s = &r->map->desc.system;
    size_t texels = (size_t)r->map->side * r->map->side;
    float share = 1.0f / (float)r->map->faces;
    for (r->face = 0; r->face < r->map->faces; r->face++) {
        rsm__face_frame(r->map, r->face, &r->right, &r->up, &r->axis);
        memset(r->winners, 0, texels * sizeof *r->winners);
        rsm__run_tasks(s, (r->triangles + RSM__CHUNK - 1) / RSM__CHUNK, rsm__bound_chunk, r);
        if (!rsm__run_steps(s, (r->map->side + RSM__BAND - 1) / RSM__BAND, rsm__draw_band, r,
                            share * (float)r->face, share * (float)(r->face + 1)))
            return RSM_ERR_CANCELLED;
    }
    return RSM_OK;
}

RSM_DEF rsm_result rsm_rasterize(rsm_map *map, const rsm_mesh *meshes, size_t mesh_count)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_rasterize");
    rsm__raster r;
    rsm__allocator a;
    rsm_result result;
    uint64_t skipped = 0;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    if (!meshes && mesh_count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "meshes", "is NULL");
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished");
    memset(&r, 0, sizeof r);
    r.map = map;
    r.meshes = meshes;
    r.mesh_count = mesh_count;
    result = rsm__meshes_check(&log, &r, &skipped);
    if (result != RSM_OK) return result;
    a = rsm__allocator_of(&map->desc.system);
    texels = rsm__texel_count(map);
    r.boxes = (rsm__box *)rsm__alloc_array(&a, r.triangles + 1, sizeof *r.boxes);
    r.winners = (uint32_t *)rsm__alloc_array(&a, (size_t)map->side * map->side, sizeof *r.winners);
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + i);
    result = r.boxes && r.winners ? rsm__raster_faces(&r) : RSM_ERR_ALLOC;
    for (i = 0; i < texels && result != RSM_OK; i++) rsm__texel_clear(map->texels + i);
    if (result == RSM_ERR_ALLOC)
        rsm__log_text(&log, "the allocator", "returned no memory for boxes of triangles");
    if (result == RSM_ERR_CANCELLED) rsm__log_text(&log, "progress", "cancelled the call");
    if (result == RSM_OK) map->stats.skipped_triangles = skipped;
    rsm__free(&a, r.winners);
    rsm__free(&a, r.boxes);
    return result;
}
