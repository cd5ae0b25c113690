/* ---- ism: arguments ---- */

typedef struct glbk__ism_range {    /* a field, its value, and the range of that if it is not 0 */
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

/* Returns a desc with defaults in place of zeros, zeros in place of what is negative for none, and without
   its system. */
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

/* Checks a shading and writes it with its defaults, as ism_shade takes them. */
static glbk_result glbk__ism_check_shading(const glbk_context *ctx, const char *function,
                                           const ism_shading *shading, ism_shading *out)
{
    memset(out, 0, sizeof *out);
    if (shading) *out = *shading;
    if (out->pattern > 8 || !glbk__ism_power_of_two(out->pattern))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.pattern", out->pattern,
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
    if (!out->pattern) out->pattern = 1;
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
    if (r->width == g->width && r->height == g->height) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "gbuffer", "is of another size than the renderer");
}

/* ---- lists ---- */

/* Logs what is wrong with a field of element i of a list. text: what the field must be, or what is wrong. */
static glbk_result glbk__ism_bad_element(const glbk_context *ctx, const char *function, const char *list,
                                         size_t i, const char *field, const char *text)
{
    glbk_ism__message name;
    name.used = 0;
    glbk_ism__message_text(&name, list);
    glbk_ism__message_text(&name, "[");
    glbk_ism__message_count(&name, i);
    glbk_ism__message_text(&name, "].");
    glbk_ism__message_text(&name, field);
    return glbk__refuse(ctx, GLBK_ERR_INPUT, function, name.text, text);
}

/* Returns whether three floats are finite. */
static int glbk__ism_finite(const float *v)
{
    float sum = v[0] * 0 + v[1] * 0 + v[2] * 0;
    return sum >= 0 && sum <= 0;
}

/* Returns whether a vector is 0.97..1.03 long; 0 for what is not a number. */
static int glbk__ism_unit(const float *v)
{
    float length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return glbk_ism__is_unit2(length2);
}

/* Returns whether three floats are a flux, 0..1e30. */
static int glbk__ism_flux(const float *v)
{
    return v[0] >= 0 && v[0] <= 1e30f && v[1] >= 0 && v[1] <= 1e30f && v[2] >= 0 && v[2] <= 1e30f;
}

/* Returns whether a window leaves something of each side of the tile. */
static int glbk__ism_window(uint32_t window)
{
    return window < 1u << 24 && (window & 63) + (window >> 12 & 63) <= 63 &&
           (window >> 6 & 63) + (window >> 18 & 63) <= 63;
}

/* Checks element i of a list of VPLs as ism_set_vpls does, and what ism.h computes besides. */
static glbk_result glbk__ism_check_vpl(const glbk_context *ctx, const ism_vpl *v, size_t i)
{
    const char *field = NULL, *text = "must be finite and not negative";
    if (!glbk__ism_finite(v->position)) field = "position", text = "must be finite";
    else if (!glbk__ism_flux(v->flux)) field = "flux", text = "must be 0..1e30";
    else if (!glbk__ism_unit(v->normal)) field = "normal", text = "must be unit (0.97..1.03 long)";
    else if (!glbk__ism_unit(v->axis)) field = "axis", text = "must be unit (0.97..1.03 long)";
    else if (!(v->exponent >= 0 && v->exponent <= 1e5f)) field = "exponent", text = "must be 0..1e5";
    else if (!(v->side >= 0 && v->side < 3e38f)) field = "side";
    else if (!(v->reach >= 0 && v->reach < 3e38f)) field = "reach";
    else if (!glbk__ism_window(v->window)) field = "window", text = "leaves nothing of a side";
    return field ? glbk__ism_bad_element(ctx, "glbk_ism_vpls_upload", "vpls", i, field, text) : GLBK_OK;
}

/* Checks element i of a list of near points. */
static glbk_result glbk__ism_check_near_point(const glbk_context *ctx, const ism_near_point *p, size_t i,
                                              uint32_t vpl_count)
{
    const char *field = NULL, *text = "must be finite";
    if (!glbk__ism_finite(p->position)) field = "position";
    else if (!glbk__ism_finite(p->normal)) field = "normal";
    else if (!glbk__ism_flux(p->flux)) field = "flux", text = "must be 0..1e30";
    else if (!(p->side >= 0 && p->side < 3e38f)) field = "side", text = "must be finite and not negative";
    else if (!(p->reach >= 0 && p->reach < 3e38f)) field = "reach", text = "must be finite and not negative";
    else if (!(p->vpl >= 0 && p->vpl < (float)vpl_count)) field = "vpl", text = "is the number of no VPL";
    if (!field) return GLBK_OK;
    return glbk__ism_bad_element(ctx, "glbk_ism_near_points_upload", "points", i, field, text);
}

/* Checks a mesh but for the values of its indices, which are checked while they are read. */
static glbk_result glbk__ism_check_mesh(const glbk_context *ctx, const char *function, const ism_mesh *mesh)
{
    const int indexed = mesh->indices || mesh->indices16;
    const size_t corners = indexed ? mesh->index_count : mesh->vertex_count;
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (mesh->indices && mesh->indices16)
        return glbk__refuse(ctx, bad, function, "mesh.indices", "and mesh.indices16 are both given");
    if (corners % 3)
        return glbk__refuse_value(ctx, bad, function, indexed ? "mesh.index_count" : "mesh.vertex_count",
                                  (double)corners, "a multiple of 3");
    if (corners && !mesh->positions) return glbk__refuse(ctx, bad, function, "mesh.positions", "is NULL");
    if (!glbk_ism__stride_valid(mesh->vertex_stride, 12))
        return glbk__refuse_value(ctx, bad, function, "mesh.vertex_stride", (double)mesh->vertex_stride,
                                  "0 or a multiple of 4, at least 12");
    if (corners > 0x7fffffff)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "the number of corners", (double)corners,
                                  "2147483647 at most");
    if (mesh->vertex_count <= 0x7fffffff) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "mesh.vertex_count", (double)mesh->vertex_count,
                              "2147483647 at most");
}
