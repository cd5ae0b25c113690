/* ---- inputs: meshes, sources and views as the caller gives them ---- */

/* Returns element i of an array of vectors; stride 0 means that the vectors follow each other. */
static const float *ism__at(const float *array, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)array + (stride ? stride : 12u) * i);
}

/* Returns the axis and the exponent of a texel's lobe, four floats. */
static const float *ism__lobe(const ism_source *s, size_t i)
{
    return ism__at(s->lobes, s->lobe_stride ? s->lobe_stride : 16u, i);
}

/* Begins a call: notes where its progress and its log go, and which function the log names. */
static void ism__begin_job(const ism_system *system, const char *function, const ism_frame *frame,
                           ism__job *job)
{
    memset(job, 0, sizeof *job);
    job->frame = frame;
    job->part.progress = system->progress;
    job->part.user = system->user;
    job->part.to = 1.0f;
    job->log.log = system->log;
    job->log.user = system->user;
    job->log.function = function;
}

/* Logs that this pointer is NULL, and returns ISM_ERR_ARGUMENT. */
static ism_result ism__is_null(const ism__logger *log, const char *name)
{
    ism__log_text(log, name, "is NULL");
    return ISM_ERR_ARGUMENT;
}

static ism_result ism__no_memory(const ism__logger *log)
{
    ism__log_text(log, "system.allocator", "returned no memory");
    return ISM_ERR_ALLOC;
}

/* Checks the array to which surfels are written. */
static ism_result ism__check_list(const ism__logger *log, const ism_surfel *out, size_t capacity,
                                  const size_t *count)
{
    if (!count) return ism__is_null(log, "count");
    return !out && capacity ? ism__is_null(log, "out") : ISM_OK;
}

static ism_result ism__check_stride(const ism__logger *log, const char *name, size_t stride, size_t least)
{
    if (ism__stride_valid(stride, least)) return ISM_OK;
    ism__log_value(log, name, (double)stride, least == 12u ? "0 or a multiple of 4, at least 12"
                                            : least == 16u ? "0 or a multiple of 4, at least 16"
                                                           : "a multiple of 4");
    return ISM_ERR_ARGUMENT;
}

/* Returns 1 if a vector is unit (0.97 to 1.03 long), 0 if it is 0 0 0 or not finite, and -1 if it has another
   length. */
static int ism__unit_kind(ism__v3 v)
{
    float length2 = ism__v3_dot(v, v);
    if (ism__is_unit2(length2)) return 1;
    return !ism__v3_finite(v) || !(length2 > 0.0f || v.x != 0.0f || v.y != 0.0f || v.z != 0.0f) ? 0 : -1;
}

static size_t ism__mesh_triangles(const ism_mesh *mesh)
{
    return !mesh ? 0 : (mesh->indices || mesh->indices16 ? mesh->index_count : mesh->vertex_count) / 3u;
}

/* Checks a mesh, but for the values of its indices, which are checked while they are read. */
static ism_result ism__check_mesh(const ism__logger *log, const ism_mesh *mesh)
{
    int indexed = mesh->indices || mesh->indices16;
    size_t count = indexed ? mesh->index_count : mesh->vertex_count;
    if (mesh->indices && mesh->indices16) {
        ism__log_text(log, "mesh.indices", "and mesh.indices16 are both given");
        return ISM_ERR_ARGUMENT;
    }
    if (count % 3u != 0) {
        ism__log_value(log, indexed ? "mesh.index_count" : "mesh.vertex_count", (double)count,
                       "a multiple of 3");
        return ISM_ERR_ARGUMENT;
    }
    if (!mesh->positions && mesh->vertex_count) return ism__is_null(log, "mesh.positions");
    if (!mesh->vertex_count && count) {
        ism__log_value(log, "mesh.vertex_count", 0.0, "above 0, for there are indices");
        return ISM_ERR_ARGUMENT;
    }
    return ism__check_stride(log, "mesh.vertex_stride", mesh->vertex_stride, 12);
}

/* Returns index i of a mesh; if the mesh has no indices, i itself. */
static size_t ism__index(const ism_mesh *mesh, size_t i)
{
    return mesh->indices ? mesh->indices[i] : mesh->indices16 ? mesh->indices16[i] : i;
}

static ism_result ism__check_indices(const ism__logger *log, const ism_mesh *mesh)
{
    size_t i, count = mesh->indices || mesh->indices16 ? 3u * ism__mesh_triangles(mesh) : 0;
    for (i = 0; i < count; i++)
        if (ism__index(mesh, i) >= mesh->vertex_count) {
            ism__log_index(log, "mesh", i, ism__index(mesh, i), mesh->vertex_count);
            return ISM_ERR_INPUT;
        }
    return ISM_OK;
}

/* Checks that opacities are 0..1. A triangle whose opacity is not a number would not be drawn, and nobody
   would know why. */
static ism_result ism__check_opacities(const ism__logger *log, const ism_mesh *mesh)
{
    size_t i, count = mesh->opacities ? ism__mesh_triangles(mesh) : 0;
    for (i = 0; i < count; i++)
        if (!(mesh->opacities[i] >= 0.0f && mesh->opacities[i] <= 1.0f)) {
            ism__log_element(log, "mesh.opacities", i, "is", (double)mesh->opacities[i], "0..1");
            return ISM_ERR_INPUT;
        }
    return ISM_OK;
}

/* Loads the corners of a triangle whose indices are known to be in range. */
static void ism__corners(const ism_mesh *mesh, size_t t, ism__v3 p[3])
{
    size_t k;
    for (k = 0; k < 3u; k++)
        p[k] = ism__v3_load(ism__at(mesh->positions, mesh->vertex_stride, ism__index(mesh, 3u * t + k)));
}

/* Checks that vectors are unit, or mean that there is no receiver. */
static ism_result ism__check_units(const ism__logger *log, const char *name, const float *array,
                                   size_t stride, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        ism__v3 v = ism__v3_load(ism__at(array, stride, i));
        if (ism__unit_kind(v) >= 0) continue;
        ism__log_element(log, name, i, "has the length", (double)ism__v3_length(v), "1 (0.97..1.03), or 0");
        return ISM_ERR_INPUT;
    }
    return ISM_OK;
}

/* Checks receivers, and finds the width and height of their picture; a list is a picture of one row. */
static ism_result ism__open_view(const ism__logger *log, const ism_points *p, ism__view *out)
{
    ism_result result;
    int k;
    if (!p) return ism__is_null(log, "points");
    if (!p->positions) return ism__is_null(log, "points.positions");
    if (!p->normals) return ism__is_null(log, "points.normals");
    if (!p->count || p->count > 1u << 28) {
        ism__log_value(log, "points.count", (double)p->count, "1..2^28");
        return p->count ? ISM_ERR_LIMIT : ISM_ERR_ARGUMENT;
    }
    if (p->width && p->count % p->width != 0) {
        ism__log_value(log, "points.width", (double)p->width, "0 or a divisor of points.count");
        return ISM_ERR_ARGUMENT;
    }
    if ((result = ism__check_stride(log, "points.position_stride", p->position_stride, 12)) != ISM_OK ||
        (result = ism__check_stride(log, "points.normal_stride", p->normal_stride, 12)) != ISM_OK ||
        (result = ism__check_stride(log, "points.geometric_normal_stride", p->geometric_normal_stride, 12)) !=
            ISM_OK ||
        (result = ism__check_stride(log, "points.albedo_stride", p->albedo_stride, 12)) != ISM_OK)
        return result;
    for (k = 0; k < 16; k++)
        if (!ism__finite(p->world_to_clip[k])) {
            ism__log_element(log, "points.world_to_clip", (uint64_t)k, "is", (double)p->world_to_clip[k],
                             "finite");
            return ISM_ERR_INPUT;
        }
    if (p->rows < ISM_ROWS_DEFAULT || p->rows >= ISM_ROWS_COUNT) {
        ism__log_value(log, "points.rows", (double)p->rows, "a value of ism_rows");
        return ISM_ERR_INPUT;
    }
    out->points = p;
    out->width = p->width ? p->width : (uint32_t)p->count;
    out->height = (uint32_t)(p->count / out->width);
    result = ism__check_units(log, "points.normals", p->normals, p->normal_stride, p->count);
    if (result != ISM_OK || !p->geometric_normals) return result;
    return ism__check_units(log, "points.geometric_normals", p->geometric_normals, p->geometric_normal_stride,
                            p->count);
}

/* Loads a receiver's position and normal. Returns 0 if there is no receiver. */
static int ism__receiver(const ism__view *view, size_t i, ism__v3 *p, ism__v3 *n)
{
    *p = ism__v3_load(ism__at(view->points->positions, view->points->position_stride, i));
    *n = ism__v3_load(ism__at(view->points->normals, view->points->normal_stride, i));
    return ism__v3_finite(*p) && ism__v3_finite(*n) && ism__v3_dot(*n, *n) > 0.25f;
}

/* Returns a receiver's geometric normal; if it has none, n, its normal. */
static ism__v3 ism__geometric_normal(const ism__view *view, size_t i, ism__v3 n)
{
    const ism_points *p = view->points;
    ism__v3 own;
    if (!p->geometric_normals) return n;
    own = ism__v3_load(ism__at(p->geometric_normals, p->geometric_normal_stride, i));
    return ism__v3_finite(own) && ism__v3_dot(own, own) > 0.25f ? own : n;
}

static float ism__luminance(const float *f) { return (f[0] + f[1] + f[2]) * (1.0f / 3.0f); }

static int ism__flux_ok(const float *f)
{
    return f[0] >= 0.0f && f[1] >= 0.0f && f[2] >= 0.0f && f[0] <= 1e30f && f[1] <= 1e30f && f[2] <= 1e30f;
}

/* Writes "sources[INDEX].NAME", for the log. */
static void ism__source_field(ism__message *m, size_t source, const char *name)
{
    m->used = 0;
    ism__message_text(m, "sources[");
    ism__message_count(m, source);
    ism__message_text(m, "].");
    ism__message_text(m, name);
}

/* Returns the flux of a pVPL, 0 if the pVPL cannot be used. Sets *bad if the data are at fault. If a vector
   is not unit, *wrong is set to the name of its array. */
static float ism__pvpl_luminance(const ism_source *s, size_t i, int *bad, const char **wrong)
{
    const float *f = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n = p;
    int kind;
    *bad = 0;
    if (!ism__flux_ok(f)) return *bad = 1, 0.0f;
    if (!(ism__luminance(f) > 0.0f)) return 0.0f;
    if (s->kind != ISM_SOURCE_DIRECTIONS) n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    kind = ism__unit_kind(n);
    if (kind < 0) *wrong = s->kind != ISM_SOURCE_DIRECTIONS ? "normals" : "positions";
    *bad = !ism__v3_finite(p) || kind == 0;
    if (s->lobes && s->kind != ISM_SOURCE_DIRECTIONS) {
        const float *lobe = ism__lobe(s, i);
        kind = ism__unit_kind(ism__v3_load(lobe));
        if (kind < 0) *wrong = "lobes";
        if (kind == 0 || !(lobe[3] >= 0.0f && lobe[3] <= 1e5f)) *bad = 1;
    }
    return *bad ? 0.0f : ism__luminance(f);
}

/* Logs that a vector of a source's texel is not unit; `wrong` is the array's name from ism__pvpl_luminance.
   */
static ism_result ism__not_unit(const ism__logger *log, const ism_source *s, size_t source, size_t i,
                                const char *wrong)
{
    ism__message name;
    ism__v3 v = ism__v3_load(wrong[0] == 'n'   ? ism__at(s->normals, s->normal_stride, i)
                             : wrong[0] == 'l' ? ism__lobe(s, i)
                                               : ism__at(s->positions, s->position_stride, i));
    ism__source_field(&name, source, wrong);
    ism__log_element(log, name.text, i, "has the length", (double)ism__v3_length(v), "1 (0.97..1.03), or 0");
    return ISM_ERR_INPUT;
}

static ism_result ism__check_source(const ism__logger *log, const ism_source *s, size_t index)
{
    ism__message name;
    ism_result result;
    if (s->kind < ISM_SOURCE_DEFAULT || s->kind >= ISM_SOURCE_COUNT) {
        ism__source_field(&name, index, "kind");
        ism__log_value(log, name.text, (double)s->kind, "a value of ism_source_kind");
        return ISM_ERR_INPUT;
    }
    ism__source_field(&name, index, !s->positions ? "positions" : !s->fluxes ? "fluxes" : "normals");
    if (!s->positions || !s->fluxes || (s->kind != ISM_SOURCE_DIRECTIONS && !s->normals))
        return ism__is_null(log, name.text);
    ism__source_field(&name, index, !s->width ? "width" : "height");
    if (!s->width || !s->height) {
        ism__log_value(log, name.text, 0.0, "above 0");
        return ISM_ERR_ARGUMENT;
    }
    ism__source_field(&name, index, "position_stride");
    if ((result = ism__check_stride(log, name.text, s->position_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "normal_stride");
    if ((result = ism__check_stride(log, name.text, s->normal_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "flux_stride");
    if ((result = ism__check_stride(log, name.text, s->flux_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "lobe_stride");
    if ((result = ism__check_stride(log, name.text, s->lobe_stride, 16)) != ISM_OK) return result;
    ism__source_field(&name, index, "area_stride");
    return ism__check_stride(log, name.text, s->area_stride, 4);
}

/* Checks all sources, and counts their texels and the doubles that their prefix sums take. */
static ism_result ism__check_sources(const ism__logger *log, const ism_frame *f, size_t *total,
                                     size_t *doubles)
{
    size_t s, cells;
    *total = *doubles = 0;
    if (f->source_count && !f->sources) return ism__is_null(log, "frame.sources");
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        ism_result result = ism__check_source(log, src, s);
        if (result != ISM_OK) return result;
        if (!ism__mul_size(src->width, src->height, &cells) || cells > 1u << 26 ||
            *total > (1u << 26) - cells) {
            ism__log_element(log, "sources", s, "brings the texels of all to", (double)*total +
                             (double)src->width * (double)src->height, "2^26 at most");
            return ISM_ERR_LIMIT;
        }
        *total += cells;
        *doubles += ism__cdf2_doubles(src->width, src->height);
    }
    return ISM_OK;
}
