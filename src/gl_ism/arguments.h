/* ---- ism: arguments: checked as ism.h checks them, with its defaults ---- */

typedef struct glbk__ism_range { double low, high; } glbk__ism_range;     /* of the values of a field but 0 */

/* Logs the first field that is out of its range. fields: of each its name and its range in words, each ended
   by 0; an empty string follows the last. (Pointers to them would take more bytes than the strings.) */
static glbk_result glbk__ism_in_range(const glbk_context *ctx, const char *function, const char *fields,
                                      const glbk__ism_range *r, const double *values)
{
    for (; *fields; r++, values++) {
        const char *wanted = fields + strlen(fields) + 1;
        if (!(*values >= r->low && *values <= r->high) && !(*values >= 0 && *values <= 0))
            return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, fields, *values, wanted);
        fields = wanted + strlen(wanted) + 1;
    }
    return GLBK_OK;
}

/* Returns whether x is a power of two, or 0. */
static int glbk__ism_power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

/* Checks the fields that count here as ism_create does. */
static glbk_result glbk__ism_check_desc(const glbk_context *ctx, const char *function, const ism_desc *d)
{
    static const char fields[] =
        "desc.vpl_count\0" "0 or 1..16384\0"
        "desc.surfel_count\0" "0 or 8..65536\0"
        "desc.tile_side\0" "0 or a power of two, 8..256\0"
        "desc.projection\0" "a value of ism_projection\0"
        "desc.lazy_frames\0" "0 or 1..64\0"
        "desc.splat_scale\0" "0..16\0"
        "desc.near_point_count\0" "64 at most\0";
    static const glbk__ism_range ranges[] = {
        { 1, 16384 }, { 8, 65536 }, { 8, 256 }, { 0, ISM_PROJECTION_COUNT - 1 }, { 1, 64 }, { 0, 16 },
        { -2147483648.0, 64 }
    };
    const uint32_t side = d->tile_side ? d->tile_side : 64;
    double values[7];
    glbk_result result;
    if (!glbk__ism_power_of_two(d->tile_side))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.tile_side", d->tile_side,
                                  "0 or a power of two, 8..256");
    values[0] = d->vpl_count;
    values[1] = d->surfel_count;
    values[2] = d->tile_side;
    values[3] = (double)d->projection;
    values[4] = d->lazy_frames;
    values[5] = (double)d->splat_scale;
    values[6] = d->near_point_count;
    result = glbk__ism_in_range(ctx, function, fields, ranges, values);
    if (result != GLBK_OK || d->window_rim <= 0) return result;
    if (d->window_rim >= 2 && (uint32_t)d->window_rim <= side / 2) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.window_rim", d->window_rim,
                              "negative, 0 or 2..tile_side / 2");
}

/* Puts defaults in place of zeros, and zeros in place of negative numbers that say none, and takes the system
   away. */
static void glbk__ism_resolve(ism_desc *d)
{
    memset(&d->system, 0, sizeof d->system);
    if (!d->vpl_count) d->vpl_count = 1024;
    if (!d->surfel_count) d->surfel_count = 8192;
    if (!d->tile_side) d->tile_side = 64;
    if (d->projection == ISM_PROJECTION_DEFAULT) d->projection = ISM_PROJECTION_COSINE;
    if (!d->lazy_frames) d->lazy_frames = 8;
    if (!d->near_point_count) d->near_point_count = 16;
    if (d->near_point_count < 0) d->near_point_count = 0;
    if (!d->window_rim) d->window_rim = d->tile_side < 16 ? 2 : (int32_t)(d->tile_side / 8);
    if (d->window_rim < 0) d->window_rim = 0;
    if (!(d->splat_scale > 0)) d->splat_scale = 0.8f;
}

/* Checks a shading as ism_shade does, and writes the shading with its defaults. */
static glbk_result glbk__ism_check_shading(const glbk_context *ctx, const char *function,
                                           const ism_shading *shading, ism_shading *out)
{
    static const char fields[] =
        "shading.near_mode\0" "a value of ism_near\0"
        "shading.bias\0" "below 1\0"
        "shading.clamp\0" "0 or above 0\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_NEAR_COUNT - 1 }, { -3.5e38, 0.99999999 }, { 0, 3e38 }
    };
    double values[3];
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (shading) *out = *shading;
    if (out->interleave > 8 || !glbk__ism_power_of_two(out->interleave))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.interleave", out->interleave,
                                  "0, 1, 2, 4 or 8");
    values[0] = (double)out->near_mode;
    values[1] = (double)out->bias;
    values[2] = (double)out->clamp;
    result = glbk__ism_in_range(ctx, function, fields, ranges, values);
    if (result != GLBK_OK) return result;
    if (out->visible_fn || out->near_visible_fn)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function,
                            out->visible_fn ? "shading.visible_fn" : "shading.near_visible_fn",
                            "is not NULL: on GL it is GLSL, glbk_ism_renderer_see");
    if (!out->interleave) out->interleave = 1;
    if (out->near_mode == ISM_NEAR_DEFAULT) out->near_mode = ISM_NEAR_GATHER;
    if (!(out->clamp > 0)) out->clamp = 1.0f;
    if (!(out->bias > 0)) out->bias = out->bias < 0 ? 0.0f : 0.02f;
    return GLBK_OK;
}

/* Checks that there is a context, and that maps were created. */
static glbk_result glbk__ism_check_maps(const glbk_context *ctx, const char *function, const glbk_ism_maps *m)
{
    if (ctx && m && m->vpls.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "maps", m ? "were not created" : "is NULL");
}

/* Checks that there is a context, and that a renderer was created. */
static glbk_result glbk__ism_check_renderer(const glbk_context *ctx, const char *function,
                                            const glbk_ism_renderer *r)
{
    if (ctx && r && r->view.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
}

/* Checks that a renderer and a G-buffer were created, for pictures of one size. */
static glbk_result glbk__ism_check_gbuffer(const glbk_context *ctx, const char *function,
                                           const glbk_ism_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result = glbk__ism_check_renderer(ctx, function, r);
    if (result != GLBK_OK) return result;
    if (!g || !g->colors.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer", g ? "was not created" : "is NULL");
    if (g->width != r->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", g->width,
                                  "that of the renderer");
    if (g->height == r->height) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", g->height,
                              "that of the renderer");
}

/* ---- lists ---- */

/* An element of a list that a call was given. */
typedef struct glbk__ism_element {
    const glbk_context *ctx;
    const char *function;           /* the call */
    const char *list;               /* the parameter */
    size_t      index;
} glbk__ism_element;

/* Ranges of numbers, and then the vectors that must be 0.97..1.03 long. */
enum { GLBK__ISM_FINITE, GLBK__ISM_FLUX, GLBK__ISM_EXPONENT, GLBK__ISM_LENGTH, GLBK__ISM_UNIT };

/* A field of an element: its first byte there, how many floats it has, and what they must be. */
typedef struct glbk__ism_field {
    char          name[11];
    unsigned char at, count, kind;
} glbk__ism_field;

/* Logs of a field (".position") "FUNCTION: LIST[INDEX]FIELD is VALUE; it must be WANTED". component: which
   number of the field is wrong, or GLBK__NO_INDEX if the field is no vector. */
static glbk_result glbk__ism_refuse_field(const glbk__ism_element *e, const char *field, size_t component,
                                          const char *of_field, double value, const char *wanted)
{
    char member[GLBK__ELEMENT_ROOM];
    glbk__name_element(member, field, component, of_field);
    return glbk__refuse_element_value(e->ctx, GLBK_ERR_INPUT, e->function, e->list, e->index, member, value,
                                      wanted);
}

/* Returns whether a float is finite. */
static int glbk__ism_finite(float x) { return x * 0 >= 0 && x * 0 <= 0; }

/* Checks a field of an element. */
static glbk_result glbk__ism_check_field(const glbk__ism_element *e, const glbk__ism_field *f,
                                         const void *element)
{
    static const struct { float low, high; char wanted[24]; } ranges[] = {
        { -3.402823466e38f, 3.402823466e38f, "finite" }, { 0, 1e30f, "0..1e30" }, { 0, 1e5f, "0..1e5" },
        { 0, 3e38f, "finite and not negative" }
    };
    float v[3] = { 0, 0, 0 }, length2;
    size_t k;
    memcpy(v, (const char *)element + f->at, 4 * (size_t)f->count);
    length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (f->kind == GLBK__ISM_UNIT)
        return glbk_ism__is_unit2(length2)
                   ? GLBK_OK
                   : glbk__ism_refuse_field(e, f->name, GLBK__NO_INDEX, "'s length", (double)sqrtf(length2),
                                            "1 (0.97..1.03)");
    for (k = 0; k < f->count; k++)
        if (!(v[k] >= ranges[f->kind].low && v[k] <= ranges[f->kind].high))
            return glbk__ism_refuse_field(e, f->name, f->count > 1 ? k : GLBK__NO_INDEX, "", (double)v[k],
                                          ranges[f->kind].wanted);
    return GLBK_OK;
}

/* Checks fields, the last of which has no floats. */
static glbk_result glbk__ism_check_fields(const glbk__ism_element *e, const glbk__ism_field *f,
                                          const void *element)
{
    glbk_result result = GLBK_OK;
    for (; f->count && result == GLBK_OK; f++) result = glbk__ism_check_field(e, f, element);
    return result;
}

/* Returns whether a window leaves something of each side of the tile. */
static int glbk__ism_window(uint32_t window)
{
    return window < 1u << 24 && (window & 63) + (window >> 12 & 63) <= 63 &&
           (window >> 6 & 63) + (window >> 18 & 63) <= 63;
}

/* Checks element i of a list of VPLs as ism_set_vpls does, and the fields that ism.h computes itself. */
static glbk_result glbk__ism_check_vpl(const glbk_context *ctx, const ism_vpl *v, size_t i)
{
    const glbk__ism_element e = { ctx, "glbk_ism_vpls_upload", "vpls", i };
    static const glbk__ism_field fields[] = {
        { ".position", offsetof(ism_vpl, position), 3, GLBK__ISM_FINITE },
        { ".flux", offsetof(ism_vpl, flux), 3, GLBK__ISM_FLUX },
        { ".normal", offsetof(ism_vpl, normal), 3, GLBK__ISM_UNIT },
        { ".axis", offsetof(ism_vpl, axis), 3, GLBK__ISM_UNIT },
        { ".exponent", offsetof(ism_vpl, exponent), 1, GLBK__ISM_EXPONENT },
        { ".edge", offsetof(ism_vpl, edge), 1, GLBK__ISM_LENGTH },
        { ".reach", offsetof(ism_vpl, reach), 1, GLBK__ISM_LENGTH },
        { "", 0, 0, 0 }
    };
    const glbk_result result = glbk__ism_check_fields(&e, fields, v);
    if (result != GLBK_OK || glbk__ism_window(v->window)) return result;
    return glbk__ism_refuse_field(&e, ".window", GLBK__NO_INDEX, "", (double)v->window,
                                  "cuts that leave something of each side");
}

/* Checks element i of a list of near points. */
static glbk_result glbk__ism_check_near_point(const glbk_context *ctx, const ism_near_point *p, size_t i,
                                              uint32_t vpl_count)
{
    const glbk__ism_element e = { ctx, "glbk_ism_near_points_upload", "points", i };
    static const glbk__ism_field fields[] = {
        { ".position", offsetof(ism_near_point, position), 3, GLBK__ISM_FINITE },
        { ".normal", offsetof(ism_near_point, normal), 3, GLBK__ISM_FINITE },
        { ".flux", offsetof(ism_near_point, flux), 3, GLBK__ISM_FLUX },
        { ".edge", offsetof(ism_near_point, edge), 1, GLBK__ISM_LENGTH },
        { ".reach", offsetof(ism_near_point, reach), 1, GLBK__ISM_LENGTH },
        { "", 0, 0, 0 }
    };
    const glbk_result result = glbk__ism_check_fields(&e, fields, p);
    if (result != GLBK_OK || (p->vpl >= 0 && p->vpl < (float)vpl_count)) return result;
    return glbk__ism_refuse_field(&e, ".vpl", GLBK__NO_INDEX, "", (double)p->vpl,
                                  "the number of an uploaded VPL");
}

/* Logs that a size of lists is another than that of the maps, for which they were made. */
static glbk_result glbk__ism_refuse_size(const glbk_context *ctx, const char *function, const char *field,
                                         size_t value, size_t wanted)
{
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    glbk__append_number(&sink, wanted);
    glbk__append_text(&sink, ", as glbk_ism_maps_create was told: give ism_create the same desc");
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, field, (double)value, line);
}

/* Checks that lists come from an ism_create with the desc of the maps, and that their sphere can be used. */
static glbk_result glbk__ism_check_info(const glbk_context *ctx, const char *function, const ism_desc *d,
                                        const ism_info *info)
{
    int k;
    if (info->surfel_count && info->surfel_count != d->surfel_count)
        return glbk__ism_refuse_size(ctx, function, "info.surfel_count", info->surfel_count, d->surfel_count);
    if (info->tile_side && info->tile_side != d->tile_side)
        return glbk__ism_refuse_size(ctx, function, "info.tile_side", info->tile_side, d->tile_side);
    if (info->lazy_frames && info->lazy_frames != d->lazy_frames)
        return glbk__ism_refuse_size(ctx, function, "info.lazy_frames", info->lazy_frames, d->lazy_frames);
    if (!(info->radius >= 0 && info->radius < 3e38f))
        return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "info.radius", (double)info->radius,
                                  "finite and not negative");
    for (k = 0; k < 3; k++)
        if (!glbk__ism_finite(info->center[k]))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "info.center", (double)info->center[k],
                                      "finite");
    return GLBK_OK;
}

/* Checks a mesh but for the values of its indices, which are checked while they are read. */
static glbk_result glbk__ism_check_mesh(const glbk_context *ctx, const char *function, const ism_mesh *mesh)
{
    const int indexed = mesh->indices || mesh->indices16;
    const size_t corners = indexed ? mesh->index_count : mesh->vertex_count;
    const char *count = indexed ? "mesh.index_count" : "mesh.vertex_count";
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (mesh->indices && mesh->indices16)
        return glbk__refuse(ctx, bad, function, "mesh.indices", "and mesh.indices16 are both given");
    if (corners % 3)
        return glbk__refuse_value(ctx, bad, function, count, (double)corners, "a multiple of 3");
    if (corners && !mesh->positions) return glbk__refuse(ctx, bad, function, "mesh.positions", "is NULL");
    if (!glbk_ism__stride_valid(mesh->vertex_stride, 12))
        return glbk__refuse_value(ctx, bad, function, "mesh.vertex_stride", (double)mesh->vertex_stride,
                                  "0 or a multiple of 4, at least 12");
    if (corners > 0x7fffffff)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, count, (double)corners,
                                  "2147483647 at most");
    if (mesh->vertex_count <= 0x7fffffff) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "mesh.vertex_count", (double)mesh->vertex_count,
                              "2147483647 at most");
}
