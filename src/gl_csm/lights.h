/* ---- csm: lights ---- */

/* A light stands in a table as ten texels, then its texels of L, running sums and triangles
   (docs/gpu-layouts.md). */
enum { GLBK__CSM_LIGHT_HEAD = 10, GLBK__CSM_TEXTURED = 1, GLBK__CSM_ORTHOGONAL = 2 };

#define GLBK__PI 3.14159265358979324

/* Returns 1 if a light is an environment, as it is by default. */
static int glbk__csm_is_sky(const lsamp_light_desc *d)
{
    return d->kind == LSAMP_LIGHT_DEFAULT || d->kind == LSAMP_LIGHT_ENVIRONMENT;
}

/* Who is told why a light is refused: the context of a call, or one that has nothing but a light's own
   log. */
typedef struct glbk__csm_logger {
    const glbk_context *ctx;
    const char         *function;
} glbk__csm_logger;

static glbk__csm_logger glbk__csm_logger_make(const glbk_context *ctx, const char *function)
{
    glbk__csm_logger log;
    log.ctx = ctx;
    log.function = function;
    return log;
}

/* Logs why a field is refused, and returns 0. */
static int glbk__csm_refuse(const glbk__csm_logger *log, const char *field, const char *text)
{
    return glbk__refuse(log->ctx, GLBK_ERR_DESC, log->function, field, text) == GLBK_OK;
}

/* Returns 1 if a number is in its range, else logs it and returns 0; wanted is the range in words. */
static int glbk__csm_field_in(const glbk__csm_logger *log, const char *field, float value, float low,
                              float high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    return glbk__refuse_value(log->ctx, GLBK_ERR_DESC, log->function, field, (double)value, wanted) ==
           GLBK_OK;
}

/* Does the same for three numbers. */
static int glbk__csm_field3_in(const glbk__csm_logger *log, const char *field, const float *v, float low,
                               float high, const char *wanted)
{
    return glbk__csm_field_in(log, field, v[0], low, high, wanted) &&
           glbk__csm_field_in(log, field, v[1], low, high, wanted) &&
           glbk__csm_field_in(log, field, v[2], low, high, wanted);
}

/* Returns 1 if a vector is unit, else logs it and returns 0. Lengths from 0.97 to 1.03 count as 1. */
static int glbk__csm_field_is_unit(const glbk__csm_logger *log, const char *field, const float *v)
{
    float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (glbk_csm__is_unit2(square)) return 1;
    return glbk__csm_refuse(log, field, "is not unit (0.97..1.03)");
}

/* Returns 1 if the GPU knows lights of this kind, else logs it and returns 0. */
static int glbk__csm_kind_valid(const glbk__csm_logger *log, const char *field, lsamp_light_kind kind)
{
    if (kind == LSAMP_LIGHT_CALLBACK)
        return glbk__csm_refuse(log, field, "is LSAMP_LIGHT_CALLBACK: GPUs call no functions");
    if ((unsigned)kind < LSAMP_LIGHT_COUNT) return 1;
    return glbk__refuse_value(log->ctx, GLBK_ERR_DESC, log->function, field, (double)kind,
                              "a LSAMP_LIGHT_...") == GLBK_OK;
}

/* ---- csm: meshes that emit ---- */

/* Returns the corners of all triangles, and below the vertex of a corner, and its place. */
static size_t glbk__csm_corner_count(const lsamp_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t glbk__csm_corner_index(const lsamp_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

static glbk_csm__v3 glbk__csm_corner(const lsamp_mesh *m, size_t i)
{
    float p[3];
    memcpy(p,
           (const char *)m->positions +
               (m->vertex_stride ? m->vertex_stride : 12) * glbk__csm_corner_index(m, i),
           sizeof p);
    return glbk_csm__v3_load(p);
}

/* Returns 1 if a mesh can emit, else logs why not and returns 0. */
static int glbk__csm_mesh_valid(const glbk__csm_logger *log, const lsamp_mesh *m)
{
    size_t i, count;
    if (!m || !m->positions || !m->vertex_count)
        return glbk__csm_refuse(log, "desc.mesh", "has no vertices");
    if (m->indices && m->indices16) return glbk__csm_refuse(log, "desc.mesh", "has two kinds of indices");
    if (m->vertex_stride % 4 || (m->vertex_stride && m->vertex_stride < 12))
        return glbk__csm_refuse(log, "desc.mesh->vertex_stride", "is not 0, nor a multiple of 4 >= 12");
    count = glbk__csm_corner_count(m);
    if (!count || count % 3 || count / 3 >= (size_t)1 << 26)
        return glbk__csm_refuse(log, "desc.mesh", "has no multiple of 3 corners");
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        if (glbk__csm_corner_index(m, i) < m->vertex_count) continue;
        return glbk__refuse_index(log->ctx, GLBK_ERR_DESC, log->function, "desc.mesh", i,
                                  glbk__csm_corner_index(m, i), m->vertex_count) == GLBK_OK;
    }
    return 1;
}

/* ---- csm: what a light may be ---- */

/* Returns 1 if the texture of a light is right for its kind, else logs why not and returns 0; the next two
   likewise, of its shape and of all of it. */
static int glbk__csm_texels_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    const int hard = d->kind == LSAMP_LIGHT_SUN || d->kind == LSAMP_LIGHT_POINT ||
                     d->kind == LSAMP_LIGHT_SPOT || d->kind == LSAMP_LIGHT_MESH;
    if (!d->texels && (d->width || d->height || d->frames > 1))
        return glbk__csm_refuse(log, "desc.texels", "is NULL, but has a size or frames");
    if (!d->texels) return 1;
    if (hard) return glbk__csm_refuse(log, "desc.texels", "is not for this kind");
    if (!d->width || d->width > 65536 || !d->height || d->height > 65536)
        return glbk__csm_refuse(log, "desc.width or desc.height", "is not in 1..65536");
    if (d->kind == LSAMP_LIGHT_LINE && d->height != 1)
        return glbk__csm_refuse(log, "desc.height", "is not 1");
    if (d->frames > (uint32_t)1 << 24) return glbk__csm_refuse(log, "desc.frames", "is more than 2^24");
    if ((uint64_t)d->width * d->height <= (uint64_t)1 << 27) return 1;     /* 65536 x 65536 passes 32 bits */
    return glbk__csm_refuse(log, "desc.texels", "are more than 2^27");
}

static int glbk__csm_shape_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    static const char lengths[] = "1e-18..1e18", places[] = "-1e18..1e18";
    const float big = 1e18f;
    float area;

    switch (d->kind) {
    case LSAMP_LIGHT_SUN: return glbk__csm_field_is_unit(log, "desc.direction", d->direction);
    case LSAMP_LIGHT_POINT: return 1;
    case LSAMP_LIGHT_SPOT:
        return glbk__csm_field_is_unit(log, "desc.direction", d->direction) &&
               glbk__csm_field_in(log, "desc.cone_half_angle", d->cone_half_angle, 5e-7f, 3.14159274f,
                                  "5e-7..pi");
    case LSAMP_LIGHT_LINE:
        if (d->u[0] == 0 && d->u[1] == 0 && d->u[2] == 0) return glbk__csm_refuse(log, "desc.u", "is 0 0 0");
        return glbk__csm_field3_in(log, "desc.u", d->u, -big, big, places) &&
               glbk__csm_field_in(log, "desc.radius", d->radius, 1e-18f, big, lengths);
    case LSAMP_LIGHT_RECTANGLE:
        if (!glbk__csm_field3_in(log, "desc.u", d->u, -big, big, places) ||
            !glbk__csm_field3_in(log, "desc.v", d->v, -big, big, places))
            return 0;
        area = glbk_csm__v3_length(glbk_csm__v3_cross(glbk_csm__v3_load(d->u), glbk_csm__v3_load(d->v)));
        return (area > 0 && glbk_csm__finite(area)) ||
               glbk__csm_refuse(log, "desc.u and desc.v", "span no area");
    case LSAMP_LIGHT_DISC:
        return glbk__csm_field_is_unit(log, "desc.direction", d->direction) &&
               glbk__csm_field_in(log, "desc.radius", d->radius, 1e-18f, big, lengths);
    case LSAMP_LIGHT_SPHERE: return glbk__csm_field_in(log, "desc.radius", d->radius, 1e-18f, big, lengths);
    case LSAMP_LIGHT_MESH: return glbk__csm_mesh_valid(log, d->mesh);
    default:
        return d->cosine_power == 0 || glbk__csm_refuse(log, "desc.cosine_power", "is not 0");
    }
}

static int glbk__csm_light_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    const float big = 1e18f;
    if (d->emission_fn)
        return glbk__csm_refuse(log, "desc.emission_fn", "is set: GPUs call no functions");
    return glbk__csm_kind_valid(log, "desc.kind", d->kind) &&
           glbk__csm_field3_in(log, "desc.radiance", d->radiance, 0, 3e38f, "0..3e38") &&
           glbk__csm_field_in(log, "desc.cosine_power", d->cosine_power, 0, 1e5f, "0..100000") &&
           glbk__csm_field_in(log, "desc.rotation", d->rotation, -1000, 1000, "-1000..1000") &&
           glbk__csm_field_in(log, "desc.time", d->time, -1e9f, 1e9f, "-1e9..1e9") &&
           glbk__csm_field_in(log, "desc.frames_per_second", d->frames_per_second, 0, 1e6f, "0..1e6") &&
           glbk__csm_field3_in(log, "desc.position", d->position, -big, big, "-1e18..1e18") &&
           glbk__csm_texels_valid(log, d) && glbk__csm_shape_valid(log, d);
}

/* Returns the texels of a light, or 0 if it is refused. */
static size_t glbk__csm_texel_count(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    if (!glbk__csm_light_valid(log, d)) return 0;
    if (d->kind == LSAMP_LIGHT_MESH) return GLBK__CSM_LIGHT_HEAD + glbk__csm_corner_count(d->mesh);
    if (!d->texels) return glbk__csm_is_sky(d) ? GLBK__CSM_LIGHT_HEAD + 3 : GLBK__CSM_LIGHT_HEAD;
    return GLBK__CSM_LIGHT_HEAD + 2 * (size_t)d->width * d->height + d->height;
}

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *d)
{
    glbk_context silent;
    glbk__csm_logger log;
    memset(&silent, 0, sizeof silent);
    log = glbk__csm_logger_make(&silent, __func__);
    return d ? glbk__csm_texel_count(&log, d) : 0;
}
