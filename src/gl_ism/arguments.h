/* ---- ism: arguments ---- */

typedef struct glbk__ism_range {    /* a field, its value, and the range of values but 0 */
    const char *field;
    double      value, low, high;
    const char *wanted;             /* the range in words */
} glbk__ism_range;

/* Logs the first field that is out of its range. */
static glbk_result glbk__ism_in_range(const glbk_context *ctx, const char *function,
                                      const glbk__ism_range *ranges, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const glbk__ism_range *r = &ranges[i];
        if ((r->value >= r->low && r->value <= r->high) || (r->value >= 0 && r->value <= 0)) continue;
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, r->field, r->value, r->wanted);
    }
    return GLBK_OK;
}

/* Returns whether x is a power of two, or 0. */
static int glbk__ism_power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

/* Checks the fields that count here as ism_create does. */
static glbk_result glbk__ism_check_desc(const glbk_context *ctx, const char *function, const ism_desc *d)
{
    const glbk__ism_range ranges[] = {
        { "desc.vpl_count", (double)d->vpl_count, 1, 16384, "0 or 1..16384" },
        { "desc.surfel_count", (double)d->surfel_count, 8, 65536, "0 or 8..65536" },
        { "desc.tile_side", (double)d->tile_side, 8, 256, "0 or a power of two, 8..256" },
        { "desc.projection", (double)d->projection, 0, ISM_PROJECTION_COUNT - 1,
          "a value of ism_projection" },
        { "desc.lazy_frames", (double)d->lazy_frames, 1, 64, "0 or 1..64" },
        { "desc.splat_scale", (double)d->splat_scale, 0, 16, "0..16" },
        { "desc.near_point_count", (double)d->near_point_count, -2147483648.0, 64, "64 at most" },
        { "desc.window_rim", d->window_rim < 0 ? 0.0 : (double)d->window_rim, 2,
          0.5 * (double)(d->tile_side ? d->tile_side : 64), "negative, 0 or 2..tile_side / 2" }
    };
    if (!glbk__ism_power_of_two(d->tile_side))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.tile_side", (double)d->tile_side,
                                  "0 or a power of two, 8..256");
    return glbk__ism_in_range(ctx, function, ranges, sizeof ranges / sizeof ranges[0]);
}

/* Returns a desc with defaults in place of zeros, zeros in place of negative numbers that say none, and
   without its system. */
static ism_desc glbk__ism_resolved(const ism_desc *desc)
{
    ism_desc d = *desc;
    memset(&d.system, 0, sizeof d.system);
    if (!d.vpl_count) d.vpl_count = 1024;
    if (!d.surfel_count) d.surfel_count = 8192;
    if (!d.tile_side) d.tile_side = 64;
    if (d.projection == ISM_PROJECTION_DEFAULT) d.projection = ISM_PROJECTION_COSINE;
    if (!d.lazy_frames) d.lazy_frames = 8;
    if (!d.near_point_count) d.near_point_count = 16;
    if (d.near_point_count < 0) d.near_point_count = 0;
    if (!d.window_rim) d.window_rim = d.tile_side < 16 ? 2 : (int32_t)(d.tile_side / 8);
    if (d.window_rim < 0) d.window_rim = 0;
    if (!(d.splat_scale > 0)) d.splat_scale = 1.0f;
    return d;
}

/* Checks a shading as ism_shade does, and writes the shading with its defaults. */
static glbk_result glbk__ism_check_shading(const glbk_context *ctx, const char *function,
                                           const ism_shading *shading, ism_shading *out)
{
    memset(out, 0, sizeof *out);
    if (shading) *out = *shading;
    if (out->interleave > 8 || !glbk__ism_power_of_two(out->interleave))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.interleave", out->interleave,
                                  "0, 1, 2, 4 or 8");
    if ((unsigned)out->near_mode >= ISM_NEAR_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.near_mode", (double)out->near_mode,
                                  "a value of ism_near");
    if (!(out->bias < 1))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.bias", (double)out->bias, "below 1");
    if (!(out->clamp >= 0 && out->clamp < 3e38f))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.clamp", (double)out->clamp,
                                  "0 or above 0");
    if (out->visible_fn || out->near_visible_fn)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function,
                            out->visible_fn ? "shading.visible_fn" : "shading.near_visible_fn",
                            "is not NULL: on GL the maps say what is seen");
    if (!out->interleave) out->interleave = 1;
    if (out->near_mode == ISM_NEAR_DEFAULT) out->near_mode = ISM_NEAR_GATHER;
    if (!(out->clamp > 0)) out->clamp = 1.0f;
    if (!(out->bias > 0)) out->bias = out->bias < 0 ? 0.0f : 0.02f;
    return GLBK_OK;
}

/* Checks that maps were created. */
static glbk_result glbk__ism_check_maps(const glbk_context *ctx, const char *function, const glbk_ism_maps *m)
{
    if (m && m->vpls.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "maps", m ? "were not created" : "is NULL");
}

/* Checks that a renderer was created. */
static glbk_result glbk__ism_check_renderer(const glbk_context *ctx, const char *function,
                                            const glbk_ism_renderer *r)
{
    if (r && r->view.name) return GLBK_OK;
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

/* Logs "FUNCTION: LIST[INDEX].FIELD WHAT VALUE; it must be WANTED". component: which number of the field is
   wrong, or -1 if the field is no vector. */
static glbk_result glbk__ism_refuse_field(const glbk__ism_element *e, const char *field, int component,
                                          const char *what, double value, const char *wanted)
{
    glbk_ism__message name, text;
    name.used = text.used = 0;
    glbk_ism__message_text(&name, e->list);
    glbk_ism__message_text(&name, "[");
    glbk_ism__message_count(&name, e->index);
    glbk_ism__message_text(&name, "].");
    glbk_ism__message_text(&name, field);
    if (component >= 0) {
        glbk_ism__message_text(&name, "[");
        glbk_ism__message_count(&name, (uint64_t)component);
        glbk_ism__message_text(&name, "]");
    }
    glbk_ism__message_text(&text, what);
    glbk_ism__message_text(&text, " ");
    glbk_ism__message_number(&text, value);
    glbk_ism__message_text(&text, "; it must be ");
    glbk_ism__message_text(&text, wanted);
    return glbk__refuse(e->ctx, GLBK_ERR_INPUT, e->function, name.text, text.text);
}

/* Returns whether a float is finite. */
static int glbk__ism_finite(float x) { return x * 0 >= 0 && x * 0 <= 0; }

/* Checks that three floats are finite. */
static glbk_result glbk__ism_check_finite(const glbk__ism_element *e, const char *field, const float *v)
{
    int k;
    for (k = 0; k < 3; k++)
        if (!glbk__ism_finite(v[k])) return glbk__ism_refuse_field(e, field, k, "is", (double)v[k], "finite");
    return GLBK_OK;
}

/* Checks that three floats are a flux. */
static glbk_result glbk__ism_check_flux(const glbk__ism_element *e, const float *v)
{
    int k;
    for (k = 0; k < 3; k++)
        if (!(v[k] >= 0 && v[k] <= 1e30f))
            return glbk__ism_refuse_field(e, "flux", k, "is", (double)v[k], "0..1e30");
    return GLBK_OK;
}

/* Checks that a vector is 0.97..1.03 long. */
static glbk_result glbk__ism_check_unit(const glbk__ism_element *e, const char *field, const float *v)
{
    const float length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (glbk_ism__is_unit2(length2)) return GLBK_OK;
    return glbk__ism_refuse_field(e, field, -1, "has the length", (double)sqrtf(length2), "1 (0.97..1.03)");
}

/* Checks that a number is within 0..most. wanted: that range in words. */
static glbk_result glbk__ism_check_number(const glbk__ism_element *e, const char *field, float value,
                                          float most, const char *wanted)
{
    if (value >= 0 && value <= most) return GLBK_OK;
    return glbk__ism_refuse_field(e, field, -1, "is", (double)value, wanted);
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
    glbk_result result = glbk__ism_check_finite(&e, "position", v->position);
    if (result == GLBK_OK) result = glbk__ism_check_flux(&e, v->flux);
    if (result == GLBK_OK) result = glbk__ism_check_unit(&e, "normal", v->normal);
    if (result == GLBK_OK) result = glbk__ism_check_unit(&e, "axis", v->axis);
    if (result == GLBK_OK) result = glbk__ism_check_number(&e, "exponent", v->exponent, 1e5f, "0..1e5");
    if (result == GLBK_OK)
        result = glbk__ism_check_number(&e, "edge", v->edge, 3e38f, "finite and not negative");
    if (result == GLBK_OK)
        result = glbk__ism_check_number(&e, "reach", v->reach, 3e38f, "finite and not negative");
    if (result != GLBK_OK || glbk__ism_window(v->window)) return result;
    return glbk__ism_refuse_field(&e, "window", -1, "is", (double)v->window,
                                  "cuts that leave something of each side");
}

/* Checks element i of a list of near points. */
static glbk_result glbk__ism_check_near_point(const glbk_context *ctx, const ism_near_point *p, size_t i,
                                              uint32_t vpl_count)
{
    const glbk__ism_element e = { ctx, "glbk_ism_near_points_upload", "points", i };
    glbk_result result = glbk__ism_check_finite(&e, "position", p->position);
    if (result == GLBK_OK) result = glbk__ism_check_finite(&e, "normal", p->normal);
    if (result == GLBK_OK) result = glbk__ism_check_flux(&e, p->flux);
    if (result == GLBK_OK)
        result = glbk__ism_check_number(&e, "edge", p->edge, 3e38f, "finite and not negative");
    if (result == GLBK_OK)
        result = glbk__ism_check_number(&e, "reach", p->reach, 3e38f, "finite and not negative");
    if (result != GLBK_OK || (p->vpl >= 0 && p->vpl < (float)vpl_count)) return result;
    return glbk__ism_refuse_field(&e, "vpl", -1, "is", (double)p->vpl, "the number of an uploaded VPL");
}

/* Logs that a size of lists is another than that of the maps, for which they were made. */
static glbk_result glbk__ism_refuse_size(const glbk_context *ctx, const char *function, const char *field,
                                         size_t value, size_t wanted)
{
    glbk_ism__message text;
    text.used = 0;
    glbk_ism__message_count(&text, wanted);
    glbk_ism__message_text(&text, ", as glbk_ism_maps_create was told: give ism_create the same desc");
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, field, (double)value, text.text);
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
