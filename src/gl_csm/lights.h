/* ---- csm: lights: what lightsampling.h's descs may say here ---- */

/* A light stands in a table as ten texels, then its texels of L, running sums and triangles
   (docs/gpu-layouts.md). */
enum { GLBK__CSM_LIGHT_HEAD = 10, GLBK__CSM_TEXTURED = 1, GLBK__CSM_ORTHOGONAL = 2, GLBK__CSM_LINEAR = 4,
       GLBK__CSM_ROUND = 8, GLBK__CSM_ROUND_SURFACE = 16, GLBK__CSM_OWN_EMISSION = 32 };

#define GLBK__PI 3.14159265358979324

/* Returns 1 if a light is an environment, as it is by default. */
static int glbk__csm_is_sky(const lsamp_light_desc *d)
{
    return d->kind == LSAMP_LIGHT_DEFAULT || d->kind == LSAMP_LIGHT_ENVIRONMENT;
}

/* Says how a refusal of a light is logged: to whom, by which public function, and where the light stands:
   "ARRAY[INDEX]", or "ARRAY" alone if the index is GLBK__NO_INDEX. */
typedef struct glbk__csm_logger {
    const glbk_context *ctx;
    const char         *function;
    const char         *array;
    size_t              index;
} glbk__csm_logger;

static glbk__csm_logger glbk__csm_logger_make(const glbk_context *ctx, const char *function,
                                              const char *array, size_t index)
{
    glbk__csm_logger log;
    log.ctx = ctx;
    log.function = function;
    log.array = array;
    log.index = index;
    return log;
}

/* Logs why a member is refused (".texels"), and returns 0. */
static int glbk__csm_refuse(const glbk__csm_logger *log, const char *member, const char *text)
{
    (void)glbk__refuse_element(log->ctx, GLBK_ERR_DESC, log->function, log->array, log->index, member, text);
    return 0;
}

/* Returns 1 if a number is in its range, else logs it and returns 0; wanted is the range in words. */
static int glbk__csm_in(const glbk__csm_logger *log, const char *member, double value, double low,
                        double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    (void)glbk__refuse_element_value(log->ctx, GLBK_ERR_DESC, log->function, log->array, log->index, member,
                                     value, wanted);
    return 0;
}

/* Does what glbk__csm_in does, for three numbers. */
static int glbk__csm_in3(const glbk__csm_logger *log, const char *member, const float *v, double low,
                         double high, const char *wanted)
{
    return glbk__csm_in(log, member, (double)v[0], low, high, wanted) &&
           glbk__csm_in(log, member, (double)v[1], low, high, wanted) &&
           glbk__csm_in(log, member, (double)v[2], low, high, wanted);
}

/* Returns 1 if a vector is unit, as the field says: a length of 0.97 to 1.03. Else logs the length under the
   name of a member and returns 0. */
static int glbk__csm_unit(const glbk__csm_logger *log, const char *member, const float *v)
{
    const glbk_csm__v3 n = glbk_csm__v3_load(v);
    if (glbk_csm__is_unit2(glbk_csm__v3_dot(n, n))) return 1;
    return glbk__csm_in(log, member, (double)glbk_csm__v3_length(n), 1, 1, "0.97..1.03");
}

/* Returns 1 if the GPU knows lights of this kind, else logs it and returns 0. own: GLSL of the user's stands
   for functions. */
static int glbk__csm_kind_valid(const glbk__csm_logger *log, lsamp_light_kind kind, int own)
{
    if (kind == LSAMP_LIGHT_CALLBACK && !own)
        return glbk__csm_refuse(log, ".kind", "is a callback, without own");
    return glbk__csm_in(log, ".kind", (double)kind, 0, LSAMP_LIGHT_COUNT - 1, "a LSAMP_LIGHT_...");
}

/* ---- csm: meshes that emit ---- */

/* Returns how many corners triangles have; glbk__csm_corner_index returns the vertex of one of them. */
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

/* Logs what a member of the mesh is, and returns the result. */
static glbk_result glbk__csm_refuse_mesh(const glbk__csm_logger *log, glbk_result result, const char *member,
                                         const char *text)
{
    return glbk__refuse_element(log->ctx, result, log->function, log->array, log->index, member, text);
}

/* Logs that a number of the mesh is out of its range, and returns the result. */
static glbk_result glbk__csm_refuse_number(const glbk__csm_logger *log, glbk_result result,
                                           const char *member, size_t value, const char *wanted)
{
    return glbk__refuse_element_value(log->ctx, result, log->function, log->array, log->index, member,
                                      (double)value, wanted);
}

/* Checks that a mesh can emit. */
static glbk_result glbk__csm_check_mesh(const glbk__csm_logger *log, const lsamp_mesh *m)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    char field[GLBK__ELEMENT_ROOM];
    size_t i, count;
    if (!m) return glbk__csm_refuse_mesh(log, GLBK_ERR_DESC, ".mesh", "is NULL");
    if (!m->positions) return glbk__csm_refuse_mesh(log, bad, ".mesh->positions", "is NULL");
    if (!m->vertex_count) return glbk__csm_refuse_mesh(log, bad, ".mesh->vertex_count", "is 0");
    if (m->indices && m->indices16)
        return glbk__csm_refuse_mesh(log, bad, ".mesh->indices", "and indices16 are given; one must be NULL");
    if (m->vertex_stride % 4 || (m->vertex_stride && m->vertex_stride < 12))
        return glbk__csm_refuse_number(log, bad, ".mesh->vertex_stride", m->vertex_stride,
                                       "0 or a multiple of 4, >= 12");
    count = glbk__csm_corner_count(m);
    if (!count || count % 3)
        return glbk__csm_refuse_number(log, bad, ".mesh's corners", count, "a multiple of 3, above 0");
    if (count / 3 >= (size_t)1 << 26)
        return glbk__csm_refuse_number(log, GLBK_ERR_LIMIT, ".mesh's corners", count, "below 3 * 2^26");
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        if (glbk__csm_corner_index(m, i) < m->vertex_count) continue;
        glbk__name_element(field, log->array, log->index, ".mesh");
        return glbk__refuse_index(log->ctx, GLBK_ERR_INPUT, log->function, field, i,
                                  glbk__csm_corner_index(m, i), m->vertex_count);
    }
    return GLBK_OK;
}

/* ---- csm: what a light may be ---- */

/* Returns 1 if the texture of a light is right for its kind, else logs why not and returns 0. So do
   glbk__csm_shape_valid, of its shape, and glbk__csm_light_valid, of all of it. */
static int glbk__csm_texels_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    const int hard = d->kind == LSAMP_LIGHT_SUN || d->kind == LSAMP_LIGHT_POINT ||
                     d->kind == LSAMP_LIGHT_SPOT || d->kind == LSAMP_LIGHT_MESH;
    if (!d->texels && (d->width || d->height || d->frame_count > 1))
        return glbk__csm_refuse(log, ".texels", "is NULL, but there are a size or frames");
    if (!d->texels) return 1;
    if (hard) return glbk__csm_refuse(log, ".texels", "are not for this kind of light");
    return glbk__csm_in(log, ".width", d->width, 1, 65536, "1..65536") &&
           glbk__csm_in(log, ".height", d->height, 1, d->kind == LSAMP_LIGHT_LINE ? 1 : 65536,
                        d->kind == LSAMP_LIGHT_LINE ? "1" : "1..65536") &&
           glbk__csm_in(log, ".frame_count", d->frame_count, 0, 16777216, "0..2^24");
}

static int glbk__csm_shape_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    static const char lengths[] = "1e-18..1e18", places[] = "-1e18..1e18";
    static const char direction[] = ".direction: its length";
    const double least = (double)1e-18f, big = (double)1e18f;
    float area;

    switch (d->kind) {
    case LSAMP_LIGHT_SUN: return glbk__csm_unit(log, direction, d->direction);
    case LSAMP_LIGHT_POINT: return 1;
    case LSAMP_LIGHT_SPOT:
        return glbk__csm_unit(log, direction, d->direction) &&
               glbk__csm_in(log, ".cone_half_angle", (double)d->cone_half_angle, (double)5e-7f,
                            (double)3.14159274f, "5e-7..pi");
    case LSAMP_LIGHT_LINE:
        if (d->u[0] == 0 && d->u[1] == 0 && d->u[2] == 0) return glbk__csm_refuse(log, ".u", "is 0 0 0");
        return glbk__csm_in3(log, ".u", d->u, -big, big, places) &&
               glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_RECTANGLE:
        if (!glbk__csm_in3(log, ".u", d->u, -big, big, places) ||
            !glbk__csm_in3(log, ".v", d->v, -big, big, places))
            return 0;
        area = glbk_csm__v3_length(glbk_csm__v3_cross(glbk_csm__v3_load(d->u), glbk_csm__v3_load(d->v)));
        if (area > 0 && glbk_csm__finite(area)) return 1;
        return glbk__csm_in(log, "'s area, of u and v,", (double)area, -1, -1, "above 0 and finite");
    case LSAMP_LIGHT_DISC:
        return glbk__csm_unit(log, direction, d->direction) &&
               glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_SPHERE: return glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_CALLBACK:
    case LSAMP_LIGHT_MESH: return 1;
    case LSAMP_LIGHT_SURFACE:
        if (!d->surface || !d->surface->points)
            return glbk__csm_refuse(log, ".surface", "is NULL, or has no points");
        return glbk__csm_in(log, ".surface->width", d->surface->width, 2, 4096, "2..4096") &&
               glbk__csm_in(log, ".surface->height", d->surface->height, 2, 4096, "2..4096");
    default:
        return glbk__csm_in(log, ".cosine_power", (double)d->cosine_power, 0, 0, "0");
    }
}

static int glbk__csm_light_valid(const glbk__csm_logger *log, const lsamp_light_desc *d, int own)
{
    static const struct { uint16_t at, count; float low, high; char member[20], wanted[12]; } numbers[] = {
        { offsetof(lsamp_light_desc, radiance), 3, 0, 1e30f, ".radiance", "0..1e30" },
        { offsetof(lsamp_light_desc, cosine_power), 1, 0, 1e5f, ".cosine_power", "0..100000" },
        { offsetof(lsamp_light_desc, rotation), 1, -1000, 1000, ".rotation", "-1000..1000" },
        { offsetof(lsamp_light_desc, time), 1, -1e9f, 1e9f, ".time", "-1e9..1e9" },
        { offsetof(lsamp_light_desc, frames_per_second), 1, 0, 1e6f, ".frames_per_second", "0..1e6" },
        { offsetof(lsamp_light_desc, position), 3, -1e18f, 1e18f, ".position", "-1e18..1e18" }
    };
    uint32_t i, k;

    if (d->emission_fn && (!own || (d->kind >= LSAMP_LIGHT_SUN && d->kind <= LSAMP_LIGHT_SPOT)))
        return glbk__csm_refuse(log, ".emission_fn", "is set without own, or for a sun, point or spot");
    if (!glbk__csm_kind_valid(log, d->kind, own) ||
        !glbk__csm_in(log, ".filter", (double)d->filter, 0, LSAMP_TEXELS_COUNT - 1, "a LSAMP_TEXELS_..."))
        return 0;
    for (i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (k = 0; k < numbers[i].count; k++) {
            float value;
            memcpy(&value, (const char *)d + numbers[i].at + 4 * k, 4);
            if (!glbk__csm_in(log, numbers[i].member, (double)value, (double)numbers[i].low,
                              (double)numbers[i].high, numbers[i].wanted))
                return 0;
        }
    return glbk__csm_texels_valid(log, d) && glbk__csm_shape_valid(log, d);
}

/* Checks a light and its mesh, whose faults are not those of the desc, and counts the light's texels. */
static glbk_result glbk__csm_count_texels(const glbk__csm_logger *log, const lsamp_light_desc *d, int own,
                                          size_t *texels)
{
    const int has_mesh = d->kind == LSAMP_LIGHT_MESH;
    const glbk_result result = !glbk__csm_light_valid(log, d, own) ? GLBK_ERR_DESC
                               : has_mesh                     ? glbk__csm_check_mesh(log, d->mesh)
                                                              : GLBK_OK;
    if (result != GLBK_OK) return result;
    if (d->texels && (double)d->width * d->height > 134217728)
        return glbk__refuse_element_value(log->ctx, GLBK_ERR_LIMIT, log->function, log->array, log->index,
                                          ".width * height", (double)d->width * d->height, "2^27 at most");
    *texels = GLBK__CSM_LIGHT_HEAD;
    if (has_mesh) *texels += glbk__csm_corner_count(d->mesh);
    else if (d->texels) *texels += 2 * (size_t)d->width * d->height + d->height;
    else if (glbk__csm_is_sky(d)) *texels += 3;
    if (d->kind == LSAMP_LIGHT_SURFACE) *texels += (size_t)d->surface->width * d->surface->height;
    return GLBK_OK;
}

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *d)
{
    glbk_context none;
    glbk__csm_logger log;
    size_t texels = 0;
    memset(&none, 0, sizeof none);
    log = glbk__csm_logger_make(&none, __func__, "desc", GLBK__NO_INDEX);
    return d && glbk__csm_count_texels(&log, d, 1, &texels) == GLBK_OK ? texels : 0;
}
