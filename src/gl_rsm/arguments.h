/* ---- rsm: arguments: checked as rsm.h and gifilter.h check them, with their defaults ---- */

enum {
    GLBK__RSM_LIST = 1024 * 64,     /* pixel lights that the list has room for */
    GLBK__RSM_TABLE = 1024,         /* the most materials, and texels a side of the noise */
    GLBK__RSM_NONE = 9,             /* the number of no picture */
    GLBK__RSM_FAR_BITS = 0x7f61b1e6 /* the bits of RSM_FAR */
};

typedef struct glbk__rsm_range {    /* a field, its value and its range */
    const char *field;
    double      value, low, high;
} glbk__rsm_range;

/* Logs the first field that is out of its range. A field that is not a number is out of any range. */
static glbk_result glbk__rsm_in_range(const glbk_context *ctx, const char *function,
                                      const glbk__rsm_range *fields, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const glbk__rsm_range *f = &fields[i];
        if (f->value >= f->low && f->value <= f->high) continue;
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, f->field, f->value, f->low, f->high);
    }
    return GLBK_OK;
}

/* Logs "FUNCTION: ARRAY[INDEX]FIELD is VALUE; it must be WANTED". field: "" or ".NAME". */
static glbk_result glbk__rsm_refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                            const char *array, size_t index, const char *field, double value,
                                            const char *wanted)
{
    glbk_rsm__message name;
    name.used = 0;
    glbk_rsm__message_text(&name, array);
    glbk_rsm__message_text(&name, "[");
    glbk_rsm__message_count(&name, index);
    glbk_rsm__message_text(&name, "]");
    glbk_rsm__message_text(&name, field);
    return glbk__refuse_value(ctx, result, function, name.text, value, wanted);
}

/* Checks that a desc has no system, since on GL the context's system gives memory and gets messages. */
static glbk_result glbk__rsm_no_system(const glbk_context *ctx, const char *function, const rsm_system *s)
{
    if (!s->allocator.alloc_fn && !s->allocator.free_fn && !s->allocator.user && !s->parallel_for &&
        !s->progress && !s->log && !s->user)
        return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.system",
                        "is not zero: on GL the context's counts");
}

/* Checks that three floats are at most 1e9 large. */
static glbk_result glbk__rsm_small_check(const glbk_context *ctx, const char *function, const char *field,
                                         const float *v)
{
    size_t i;
    for (i = 0; i < 3; i++)
        if (!(fabsf(v[i]) <= 1e9f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_DESC, function, field, i, "", (double)v[i],
                                            "-1e9..1e9");
    return GLBK_OK;
}

/* Checks direction, radius and cone of a light. */
static glbk_result glbk__rsm_shape_check(const glbk_context *ctx, const char *function, const rsm_light *l)
{
    const glbk_result bad = GLBK_ERR_DESC;
    const float angle = l->cone_half_angle, most = l->kind == RSM_LIGHT_SPOT ? 3.14f : 1.0f;
    const int spot = l->kind == RSM_LIGHT_SPOT || l->kind == RSM_LIGHT_SQUARE_SPOT;
    const float d2 = l->direction[0] * l->direction[0] + l->direction[1] * l->direction[1] +
                     l->direction[2] * l->direction[2];
    if (l->kind != RSM_LIGHT_POINT && !(d2 > 1e-30f && d2 <= 1e30f))
        return glbk__refuse_value(ctx, bad, function, "the length of light.direction", sqrt((double)d2),
                                  "1e-15..1e15");
    if (l->kind == RSM_LIGHT_SUN && !(l->radius > 0.0f && l->radius <= 1e9f))
        return glbk__refuse_value(ctx, bad, function, "light.radius", (double)l->radius,
                                  "above 0, at most 1e9");
    if (spot && !(angle > 0.5e-3f && angle <= most))
        return glbk__refuse_value(ctx, bad, function, "light.cone_half_angle", (double)angle,
                                  l->kind == RSM_LIGHT_SPOT ? "above 0.0005, at most 3.14"
                                                            : "above 0.0005, at most 1");
    return GLBK_OK;
}

/* Checks a light as rsm.h does, and writes the light with its defaults. */
static glbk_result glbk__rsm_light_check(const glbk_context *ctx, const char *function,
                                         const rsm_light *light, rsm_light *l)
{
    const glbk_result bad = GLBK_ERR_DESC;
    glbk_result result;
    size_t i;
    if (!light) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "light", "is NULL");
    *l = *light;
    if (l->kind == RSM_LIGHT_DEFAULT) l->kind = RSM_LIGHT_SUN;
    if ((unsigned)l->kind >= RSM_LIGHT_COUNT)
        return glbk__refuse_value(ctx, bad, function, "light.kind", (double)l->kind, "one of rsm_light_kind");
    result = glbk__rsm_small_check(ctx, function, "light.position", l->position);
    if (result == GLBK_OK) result = glbk__rsm_small_check(ctx, function, "light.up", l->up);
    for (i = 0; i < 3 && result == GLBK_OK; i++)
        if (!(l->value[i] >= 0.0f && l->value[i] <= 1e12f))
            result = glbk__rsm_refuse_element(ctx, bad, function, "light.value", i, "", (double)l->value[i],
                                              "0..1e12");
    if (result == GLBK_OK) result = glbk__rsm_shape_check(ctx, function, l);
    if (result != GLBK_OK) return result;
    if (!(fabsf(l->near_depth) > 0.0f) && !(fabsf(l->far_depth) > 0.0f)) {
        l->near_depth = l->kind == RSM_LIGHT_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == RSM_LIGHT_SUN ? l->radius : 1e3f;
    }
    if (!(fabsf(l->near_depth) <= 1e9f) || (l->kind != RSM_LIGHT_SUN && !(l->near_depth > 0.0f)))
        return glbk__refuse_value(ctx, bad, function, "light.near_depth", (double)l->near_depth,
                                  l->kind == RSM_LIGHT_SUN ? "-1e9..1e9" : "above 0, at most 1e9");
    if (l->far_depth > l->near_depth && l->far_depth <= 1e9f) return GLBK_OK;
    return glbk__refuse_value(ctx, bad, function, "light.far_depth", (double)l->far_depth,
                              "above near_depth, at most 1e9");
}

/* ---- maps, renderers and G-buffers that a call was given ---- */

/* Checks that a map was created. */
static glbk_result glbk__rsm_map_check(const glbk_context *ctx, const char *function, const glbk_rsm_map *map)
{
    if (map && map->texels.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "map", map ? "was not created" : "is NULL");
}

/* Checks that a renderer was created. */
static glbk_result glbk__rsm_renderer_check(const glbk_context *ctx, const char *function,
                                            const glbk_rsm_renderer *r)
{
    if (r && r->frame.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
}

/* Checks that a renderer and a G-buffer were created, for pictures of one size. */
static glbk_result glbk__rsm_gbuffer_check(const glbk_context *ctx, const char *function,
                                           const glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer)
{
    const glbk_result result = glbk__rsm_renderer_check(ctx, function, r);
    if (result != GLBK_OK) return result;
    if (!gbuffer || !gbuffer->colors.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer",
                            gbuffer ? "was not created" : "is NULL");
    if (gbuffer->width != r->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", gbuffer->width,
                                  "that of the renderer");
    if (gbuffer->height == r->height) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", gbuffer->height,
                              "that of the renderer");
}

/* Checks that a renderer and all maps were created, and that there is a map. */
static glbk_result glbk__rsm_maps_check(const glbk_context *ctx, const char *function,
                                        const glbk_rsm_renderer *r, const glbk_rsm_map *const *maps,
                                        uint32_t count)
{
    const glbk_result result = glbk__rsm_renderer_check(ctx, function, r);
    uint32_t i;
    if (result != GLBK_OK) return result;
    if (!maps) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "maps", "is NULL");
    if (!count)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "map_count", 0, "1 at least");
    for (i = 0; i < count; i++) {
        glbk_rsm__message name;
        if (maps[i] && maps[i]->texels.name) continue;
        name.used = 0;
        glbk_rsm__message_text(&name, "maps[");
        glbk_rsm__message_count(&name, i);
        glbk_rsm__message_text(&name, "]");
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, name.text,
                            maps[i] ? "was not created" : "is NULL");
    }
    return GLBK_OK;
}

/* ---- descs of rsm.h and gifilter.h, with their defaults ---- */

/* Checks a desc of direct light as rsm_direct does, and writes the desc with its defaults. */
static glbk_result glbk__rsm_direct_check(const glbk_context *ctx, const rsm_direct_desc *desc,
                                          rsm_direct_desc *out)
{
    static const char function[] = "glbk_rsm_direct";
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    {
        const glbk__rsm_range fields[] = { { "desc.tap_side", (double)out->tap_side, 0, 15 },
                                           { "desc.bias", (double)out->bias, -1e6, 1e6 },
                                           { "desc.slope_bias", (double)out->slope_bias, -1e6, 1e6 } };
        result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    }
    if (result == GLBK_OK) result = glbk__rsm_no_system(ctx, function, &out->system);
    if (result != GLBK_OK) return result;
    if (out->add)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.add", (double)out->add,
                                  "0: give all maps to one call");
    if (!out->tap_side) out->tap_side = 2;
    if (!(fabsf(out->bias) > 0.0f)) out->bias = 0.5f;
    if (!(fabsf(out->slope_bias) > 0.0f)) out->slope_bias = 1.0f;
    if (out->bias < 0.0f) out->bias = 0.0f;
    if (out->slope_bias < 0.0f) out->slope_bias = 0.0f;
    return GLBK_OK;
}

/* Checks a desc of bounced light as rsm_gather does, and writes the desc with its defaults. */
static glbk_result glbk__rsm_gather_check(const glbk_context *ctx, const char *function,
                                          const rsm_gather_desc *desc, rsm_gather_desc *out)
{
    const uint32_t k = desc ? desc->interleave : 0;
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    {
        const glbk__rsm_range fields[] = {
            { "desc.pattern", (double)out->pattern, 0, RSM_PATTERN_COUNT - 1 },
            { "desc.sample_count", (double)out->sample_count, 0,
              out->pattern == RSM_PATTERN_POISSON ? 4096.0 : 1048576.0 },
            { "desc.r_max", (double)out->r_max, 0, 1e3 },
            { "desc.r_min", (double)out->r_min, 0, 0.99999994 },
            { "desc.offset", (double)out->offset, 0, 1e9 },
            { "desc.clamp", (double)out->clamp, 0, (double)1e18f },
            { "desc.near_limit", (double)out->near_limit, 0, 1e6 },
            { "desc.near_field", (double)out->near_field, 0, 32 }
        };
        result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    }
    if (result == GLBK_OK) result = glbk__rsm_no_system(ctx, function, &out->system);
    if (result != GLBK_OK) return result;
    if (k > 8 || (k & (k - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.interleave", k, "0, 1, 2, 4 or 8");
    if (out->add)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.add", (double)out->add,
                                  "0: give all maps to one call");
    if (out->visible_fn)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.visible_fn",
                            "is not NULL: a GPU cannot call it; gl_ism.h has shadows of bounced light");
    if (!out->materials && out->material_count)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.materials",
                            "is NULL, and material_count is not 0");
    if (out->noise && !out->noise_side)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.noise_side", 0, 1, GLBK__RSM_TABLE);
    if (!k) out->interleave = 1;
    if (out->pattern == RSM_PATTERN_DEFAULT) out->pattern = RSM_PATTERN_FLUX;
    if (!(out->r_min > 0.0f)) out->r_min = 1.0f / 32.0f;
    return GLBK_OK;
}

/* Checks interpolation as rsm_interpolate does, and writes the struct with its defaults. */
static glbk_result glbk__rsm_interpolation_check(const glbk_context *ctx, const rsm_interpolation *how,
                                                 rsm_interpolation *out)
{
    static const char function[] = "glbk_rsm_interpolate";
    memset(out, 0, sizeof *out);
    if (how) *out = *how;
    if (!out->step) out->step = 8;
    if (out->step < 2 || out->step > 64 || (out->step & (out->step - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "interpolation.step", out->step,
                                  "0 or a power of two, 2..64");
    {
        const glbk__rsm_range fields[] = {
            { "interpolation.level_count", (double)out->level_count, 0, 6 },
            { "interpolation.normal_cosine", (double)out->normal_cosine, -1, 1 },
            { "interpolation.plane_slope", (double)out->plane_slope, 0, 1e6 },
            { "interpolation.distance", (double)out->distance, 0, 1e9 },
            { "interpolation.contrast", (double)out->contrast, -1e6, 1e6 },
            { "interpolation.light_share", (double)out->light_share, -1e6, 1e6 }
        };
        const glbk_result result = glbk__rsm_in_range(ctx, function, fields,
                                                      sizeof fields / sizeof fields[0]);
        if (result != GLBK_OK) return result;
    }
    if (out->mask)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "interpolation.mask",
                            "is not NULL: alpha of glbk_rsm_read says what each pixel is");
    if (!out->level_count) out->level_count = 6;
    if (!(fabsf(out->normal_cosine) > 0.0f)) out->normal_cosine = 0.95f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.05f;
    if (!(fabsf(out->contrast) > 0.0f)) out->contrast = 0.25f;
    if (!(fabsf(out->light_share) > 0.0f)) out->light_share = 0.25f;
    return GLBK_OK;
}

/* Checks a frame of the filter as gifilt_apply does, and writes the frame with its defaults. */
static glbk_result glbk__rsm_frame_check(const glbk_context *ctx, const gifilt_frame *frame,
                                         gifilt_frame *out)
{
    static const char function[] = "glbk_rsm_denoise";
    size_t i;
    memset(out, 0, sizeof *out);
    if (frame) *out = *frame;
    {
        const glbk__rsm_range fields[] = {
            { "frame.rows", (double)out->rows, 0, GIFILT_ROWS_COUNT - 1 },
            { "frame.history", (double)out->history, 0, 1000 },
            { "frame.passes", (double)out->passes, -1e9, 6 },
            { "frame.normal_cosine", (double)out->normal_cosine, 0, 0.99999994 },
            { "frame.plane_slope", (double)out->plane_slope, 0, 1e6 }
        };
        const glbk_result result = glbk__rsm_in_range(ctx, function, fields,
                                                      sizeof fields / sizeof fields[0]);
        if (result != GLBK_OK) return result;
    }
    for (i = 0; i < 16 && out->world_to_clip; i++)
        if (!(fabsf(out->world_to_clip[i]) <= 3.0e38f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_DESC, function, "frame.world_to_clip", i, "",
                                            (double)out->world_to_clip[i], "finite");
    if (out->motion)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "frame.motion",
                            "is not NULL: on GL motion is a texture");
    if (!out->history) out->history = 8;
    if (!out->passes) out->passes = 2;
    if (out->passes < 0) out->passes = 0;
    if (!(out->normal_cosine > 0.0f)) out->normal_cosine = 0.9f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.1f;
    return GLBK_OK;
}

/* ---- tables ---- */

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *d)
{
    uint32_t samples, sets;
    if (!d || !d->sample_count || d->pattern == RSM_PATTERN_DEFAULT || d->pattern == RSM_PATTERN_FLUX)
        return 0;
    sets = d->interleave ? d->interleave * d->interleave : 1;
    samples = d->pattern == RSM_PATTERN_MIXED ? 3 * d->sample_count / 5 : d->sample_count;
    return (samples + sets - 1) / sets * sets;
}

/* Checks noise and materials as rsm_gather does. */
static glbk_result glbk__rsm_values_check(const glbk_context *ctx, const rsm_gather_desc *d)
{
    static const char function[] = "glbk_rsm_tables_upload";
    const uint32_t count = d->materials ? d->material_count : 0, side = d->noise ? d->noise_side : 0;
    uint32_t i;
    if (side > GLBK__RSM_TABLE)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.noise_side", side, 1, GLBK__RSM_TABLE);
    if (count > GLBK__RSM_TABLE)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.material_count", count, 0,
                                  GLBK__RSM_TABLE);
    for (i = 0; i < side * side; i++)
        if (!(d->noise[i] >= 0.0f && d->noise[i] <= 1.0f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.noise", i, "",
                                            (double)d->noise[i], "0..1");
    for (i = 0; i < count; i++) {
        const rsm_material *m = &d->materials[i];
        int c;
        if (!(m->exponent >= 0.0f && m->exponent <= 1e4f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.materials", i, ".exponent",
                                            (double)m->exponent, "0..1e4");
        for (c = 0; c < 3; c++)
            if (!(m->specular[c] >= 0.0f && m->specular[c] <= 1.0f))
                return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.materials", i,
                                                ".specular", (double)m->specular[c], "0..1");
    }
    return GLBK_OK;
}

/* Checks that the tables on the GPU are those of a checked desc, as far as the desc needs tables. */
static glbk_result glbk__rsm_tables_check(const glbk_context *ctx, const char *function,
                                          const glbk_rsm_renderer *r, const rsm_gather_desc *d)
{
    const rsm_gather_desc *t = &r->tables;
    const int about = glbk_rsm_point_count(d) > 0;
    const struct {
        int counts;                     /* whether this pattern depends on the field */
        const char *field;
        double value, uploaded;
    } fields[] = {
        { about, "desc.pattern", (double)d->pattern, (double)t->pattern },
        { about, "desc.sample_count", (double)d->sample_count, (double)t->sample_count },
        { about, "desc.interleave", (double)d->interleave, (double)t->interleave },
        { about, "desc.seed", (double)d->seed, (double)t->seed },
        { about && d->pattern == RSM_PATTERN_EQUATION3, "desc.paper_weights", (double)(d->paper_weights != 0),
          (double)(t->paper_weights != 0) },
        { about && d->pattern == RSM_PATTERN_LOG_RADIAL, "desc.r_min", (double)d->r_min, (double)t->r_min },
        { about && d->noise, "desc.noise_side", (double)d->noise_side, (double)r->noise_side },
        { d->materials != NULL, "desc.material_count", (double)d->material_count, (double)r->material_count }
    };
    size_t i;
    for (i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        glbk_rsm__message text;
        if (!fields[i].counts || !(fabs(fields[i].value - fields[i].uploaded) > 0.0)) continue;
        text.used = 0;
        glbk_rsm__message_number(&text, fields[i].uploaded);
        glbk_rsm__message_text(&text, ", which glbk_rsm_tables_upload was given last");
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, fields[i].field, fields[i].value,
                                  text.text);
    }
    return GLBK_OK;
}
