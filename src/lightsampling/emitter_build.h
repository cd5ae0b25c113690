/* ---- emitter: a desc checked, a light made of it, and public questions ---- */

/* Says whether a field lies within low..high; if not, logs so. log may be NULL. */
static int lsamp__field_valid(const lsamp__logger *log, const char *field, float value, float low, float high,
                              const char *wanted)
{
    if (lsamp__in(value, low, high)) return 1;
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return 0;
}

static int lsamp__field3_valid(const lsamp__logger *log, const char *field, const float *value, float low,
                               float high, const char *wanted)
{
    return lsamp__field_valid(log, field, value[0], low, high, wanted) &&
           lsamp__field_valid(log, field, value[1], low, high, wanted) &&
           lsamp__field_valid(log, field, value[2], low, high, wanted);
}

static int lsamp__count_valid(const lsamp__logger *log, const char *field, uint32_t value, uint32_t low,
                              uint32_t high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return 0;
}

/* Logs that a field of this kind of light is set or missing against the rule. Returns 0. */
static int lsamp__light_refuse(const lsamp__logger *log, const char *field, const char *text)
{
    if (log) lsamp__log_text(log, field, text);
    return 0;
}

static int lsamp__direction_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (lsamp__is_unit(d->direction)) return 1;
    if (log)
        lsamp__log_value(log, "the length of desc.direction",
                         (double)lsamp__v3_length(lsamp__v3_load(d->direction)), "1 (0.97..1.03)");
    return 0;
}

static int lsamp__texels_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (d->texels)
        return lsamp__count_valid(log, "desc.width", d->width, 1, 65536, "1..65536 with texels") &&
               lsamp__count_valid(log, "desc.height", d->height, 1, d->kind == LSAMP_LIGHT_LINE ? 1 : 65536,
                                  d->kind == LSAMP_LIGHT_LINE ? "1 for a line" : "1..65536 with texels") &&
               lsamp__count_valid(log, "desc.frame_count", d->frame_count, 0, 1u << 24, "0 or 1..2^24");
    return lsamp__count_valid(log, "desc.width", d->width, 0, 0, "0 without texels") &&
           lsamp__count_valid(log, "desc.height", d->height, 0, 0, "0 without texels") &&
           lsamp__count_valid(log, "desc.frame_count", d->frame_count, 0, 1, "0 or 1 without texels");
}

/* Says whether the fields of a sun, point or spot are valid; if not, logs so. */
static int lsamp__delta_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (d->texels) return lsamp__light_refuse(log, "desc.texels", "is set: sun, point and spot have none");
    if (d->emission_fn)
        return lsamp__light_refuse(log, "desc.emission_fn", "is set: sun, point and spot have none");
    if (d->kind == LSAMP_LIGHT_POINT) return 1;
    return lsamp__direction_valid(log, d) &&
           (d->kind == LSAMP_LIGHT_SUN || lsamp__field_valid(log, "desc.cone_half_angle", d->cone_half_angle,
                                                             5e-7f, 0.5f * LSAMP__PI, "5e-7..pi / 2"));
}

/* Says whether the fields of a shape that has an area are valid; if not, logs so. */
static int lsamp__shape_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    const float big = 1e18f;
    lsamp__v3 n = lsamp__v3_cross(lsamp__v3_load(d->u), lsamp__v3_load(d->v));

    if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        if (!lsamp__field3_valid(log, "desc.u", d->u, -big, big, "-1e18..1e18") ||
            !lsamp__field3_valid(log, "desc.v", d->v, -big, big, "-1e18..1e18"))
            return 0;
        if (lsamp__v3_finite(n) && lsamp__v3_length(n) > 0.0f && lsamp__finite(lsamp__v3_length(n))) return 1;
        return lsamp__light_refuse(log, "desc.u", "and desc.v span no area");
    }
    if (d->kind == LSAMP_LIGHT_LINE) {
        if (!lsamp__field3_valid(log, "desc.u", d->u, -big, big, "-1e18..1e18")) return 0;
        if (!(lsamp__v3_length(lsamp__v3_load(d->u)) > 0.0f))
            return lsamp__light_refuse(log, "desc.u", "has no length");
    }
    return (d->kind != LSAMP_LIGHT_DISC || lsamp__direction_valid(log, d)) &&
           lsamp__field_valid(log, "desc.radius", d->radius, 1e-18f, big, "1e-18..1e18");
}

/* Says whether a surface is valid. Its points may move from frame to frame: they are looked at when drawn. */
static int lsamp__surface_valid(const lsamp__logger *log, const lsamp_surface *s)
{
    if (!s) return lsamp__light_refuse(log, "desc.surface", "is NULL");
    if (!s->points) return lsamp__light_refuse(log, "desc.surface->points", "is NULL");
    return lsamp__count_valid(log, "desc.surface->width", s->width, 2, 4096, "2..4096") &&
           lsamp__count_valid(log, "desc.surface->height", s->height, 2, 4096, "2..4096");
}

/* Checks the fields that only a mesh has, and the mesh, whose faults are not those of the desc. */
static lsamp_result lsamp__mesh_light_check(const lsamp__logger *log, const lsamp_light_desc *d)
{
    lsamp_result result;
    if (d->texels) {
        (void)lsamp__light_refuse(log, "desc.texels", "is set: a mesh has none");
        return LSAMP_ERR_DESC;
    }
    result = lsamp__mesh_check(d->mesh, log);
    if (result != LSAMP_OK) return result;
    return lsamp__count_valid(log, "desc.place_count", d->place_count, 0, 1u << 24, "0 or 1..2^24") &&
                   lsamp__field_valid(log, "desc.radius", d->radius, 0.0f, 1e18f, "0..1e18")
               ? LSAMP_OK
               : LSAMP_ERR_DESC;
}

/* Says whether the fields of all kinds of light are valid, but for a mesh's. */
static int lsamp__fields_valid(const lsamp_light_desc *d, const lsamp__logger *log)
{
    const float big = 1e18f;

    if ((unsigned)d->kind >= (unsigned)LSAMP_LIGHT_COUNT) {
        if (log) lsamp__log_value(log, "desc.kind", (double)d->kind, "a LSAMP_LIGHT_...");
        return 0;
    }
    if (!lsamp__field3_valid(log, "desc.radiance", d->radiance, 0.0f, 1e30f, "0..1e30") ||
        !lsamp__field_valid(log, "desc.time", d->time, -1e9f, 1e9f, "-1e9..1e9") ||
        !lsamp__field_valid(log, "desc.cosine_power", d->cosine_power, 0.0f, 1e5f, "0..100000") ||
        !lsamp__field_valid(log, "desc.rotation", d->rotation, -1000.0f, 1000.0f, "-1000..1000") ||
        !lsamp__field_valid(log, "desc.frames_per_second", d->frames_per_second, 0.0f, 1e6f, "0..1000000") ||
        !lsamp__texels_valid(log, d))
        return 0;
    if ((unsigned)d->filter >= (unsigned)LSAMP_TEXELS_COUNT) {
        if (log) lsamp__log_value(log, "desc.filter", (double)d->filter, "a LSAMP_TEXELS_...");
        return 0;
    }
    switch (d->kind) {
    case LSAMP_LIGHT_DEFAULT:
    case LSAMP_LIGHT_ENVIRONMENT:
        return lsamp__field_valid(log, "desc.cosine_power", d->cosine_power, 0.0f, 0.0f,
                                  "0 for an environment");
    case LSAMP_LIGHT_CALLBACK:
        return d->shape_fn != NULL || lsamp__light_refuse(log, "desc.shape_fn", "is NULL");
    case LSAMP_LIGHT_MESH: return 1;
    case LSAMP_LIGHT_SURFACE: return lsamp__surface_valid(log, d->surface);
    default: break;
    }
    if (!lsamp__field3_valid(log, "desc.position", d->position, -big, big, "-1e18..1e18")) return 0;
    return d->kind <= LSAMP_LIGHT_SPOT ? lsamp__delta_valid(log, d) : lsamp__shape_valid(log, d);
}

static lsamp_result lsamp__emitter_check(const lsamp_light_desc *d, const lsamp__logger *log)
{
    if (!lsamp__fields_valid(d, log)) return LSAMP_ERR_DESC;
    return d->kind == LSAMP_LIGHT_MESH ? lsamp__mesh_light_check(log, d) : LSAMP_OK;
}

static int lsamp__is_environment(const lsamp_light_desc *d)
{
    return d->kind == LSAMP_LIGHT_DEFAULT || d->kind == LSAMP_LIGHT_ENVIRONMENT;
}

#define LSAMP__EMITTER_HEAD ((sizeof(struct lsamp_light) + 15u) & ~(size_t)15u)

LSAMP_DEF size_t lsamp_light_triangles(const lsamp_light *light, float *corners)
{
    uint32_t i;
    if (!light || !light->curve) return 0;
    for (i = 0; corners && i < light->curve->count; i++)
        memcpy(corners + 9u * (size_t)i, light->curve->pieces[i].v, 9 * sizeof *corners);
    return light->curve->count;
}

LSAMP_DEF size_t lsamp_light_bytes(const lsamp_light_desc *desc)
{
    size_t doubles, edges, bytes;
    uint32_t w, h;

    if (!desc || lsamp__emitter_check(desc, NULL) != LSAMP_OK) return 0;
    if (desc->kind == LSAMP_LIGHT_MESH) {
        bytes = lsamp__curve_size(desc);
        return bytes && lsamp__add_size(bytes, LSAMP__EMITTER_HEAD, &bytes) ? bytes : 0;
    }
    if (!desc->texels && !lsamp__is_environment(desc)) return LSAMP__EMITTER_HEAD;
    w = desc->texels ? desc->width : 1u;
    h = desc->texels ? desc->height : 1u;
    edges = lsamp__is_environment(desc) ? h + 1u : 0u;
    doubles = lsamp__cdf2_doubles(w, h);
    /* First come texels, one row of weights and the guides, then the sums. Sides are 65536 at most, so that
       14 h + 4 never overflows. */
    if (!doubles || !lsamp__mul_size(w, (size_t)h * 14u + 4u, &bytes) ||
        !lsamp__add_size(bytes, LSAMP__EMITTER_HEAD + 2u * h, &bytes) ||
        !lsamp__add_size(doubles, edges, &doubles) || !lsamp__mul_size(doubles, sizeof(double), &doubles) ||
        !lsamp__add_size(bytes, doubles, &bytes))
        return 0;
    return bytes;
}

/* Returns cos(pi y / h) to the last digits of a double, by sines up to pi / 4, so that rows at the poles keep
   their digits (T12). */
static double lsamp__row_edge(uint32_t y, uint32_t h)
{
    uint32_t m = y < h - y ? y : h - y;
    double x = 1.5707963267948966 * m / h, z = x * x, s;
    s = 1.0 - z / 110.0 * (1.0 - z / 156.0 * (1.0 - z / 210.0));
    s = x * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * s))));
    s = 1.0 - 2.0 * s * s;
    return m == y ? s : -s;
}

/* Writes the texels at desc.time, which are blended from the two frames nearest in time; bad channels become
   0. Returns the number of bad texels. */
static uint64_t lsamp__emitter_frame(const lsamp_light_desc *d, float *texels)
{
    uint32_t frames = d->frame_count ? d->frame_count : 1u, f0, f1;
    size_t count = (size_t)d->width * d->height, i;
    double t = (double)d->time * (d->frames_per_second > 0.0f ? (double)d->frames_per_second : 30.0);
    float blend;
    uint64_t bad = 0;

    if (d->loop) t -= floor(t / frames) * frames;
    t = t > 0.0 ? t : 0.0;
    if (!d->loop && t > frames - 1.0) t = frames - 1.0;
    f0 = t < frames ? (uint32_t)t : 0u;
    f1 = (f0 + 1u) % frames;
    blend = t < frames ? (float)(t - f0) : 0.0f;
    for (i = 0; i < count; i++) {
        int c, broken = 0;
        for (c = 0; c < 3; c++) {
            float a = d->texels[(f0 * count + i) * 3u + (size_t)c];
            float b = blend > 0.0f ? d->texels[(f1 * count + i) * 3u + (size_t)c] : 0.0f;
            if (!lsamp__finite(a) || a < 0.0f) broken = 1, a = 0.0f;
            if (!lsamp__finite(b) || b < 0.0f) broken = 1, b = 0.0f;
            texels[i * 3u + (size_t)c] = a * (1.0f - blend) + b * blend;
        }
        bad += (uint64_t)broken;
    }
    return bad;
}

/* Makes the cdf over the texels, in proportion to the light that they send out in all three channels together
   (T18). */
static void lsamp__emitter_cdf(lsamp_light *l, double *memory, float *row, uint16_t *guide)
{
    uint32_t w = l->desc.width, h = l->desc.height, x, y;
    double *rows = memory, *sums = memory + h + 1u, total = 0.0;
    float top = l->radiance.x > l->radiance.y ? l->radiance.x : l->radiance.y, norm;
    lsamp__v3 tint = lsamp__v3_make(1.0f, 1.0f, 1.0f);

    top = top > l->radiance.z ? top : l->radiance.z;
    if (top > 0.0f) tint = lsamp__v3_make(l->radiance.x / top, l->radiance.y / top, l->radiance.z / top);
    tint = lsamp__v3_scale(tint, 1.0f / 3.0f);
    for (y = 0; y < h; y++) {
        lsamp__cdf line;
        double *at = sums + (size_t)y * (w + 1u);
        for (x = 0; x < w; x++) row[x] = lsamp__v3_dot(lsamp__texel_mean(l, x, y), tint);
        (void)lsamp__cdf_build(&line, at, row, w, l->edges ? l->edges[y] - l->edges[y + 1u] : 1.0);
        lsamp__guide_build(at, guide + h + (size_t)y * w, w);
        rows[y] = total;
        total += lsamp__cdf_total(&line);
    }
    rows[h] = total;
    lsamp__guide_build(rows, guide, h);
    l->guide = guide;
    norm = (float)(total > 0.0 ? (l->edges ? w / (6.283185307179586 * total) : (double)w * h / total) : 0.0);
    l->tint = lsamp__v3_scale(tint, norm);
    l->cdf.rows = rows;
    l->cdf.sums = sums;
    l->cdf.width = w;
    l->cdf.height = h;
}

/* Replaces the default kind by what it is, and that of a surface by the kind by whose code it is drawn. */
static void lsamp__emitter_kind(lsamp_light *l)
{
    lsamp_light_desc *d = &l->desc;
    if (d->kind == LSAMP_LIGHT_DEFAULT) d->kind = LSAMP_LIGHT_ENVIRONMENT;
    if (d->kind != LSAMP_LIGHT_SURFACE) d->surface = NULL;
    l->round = d->kind == LSAMP_LIGHT_ENVIRONMENT || d->kind == LSAMP_LIGHT_SPHERE ||
               (d->surface && d->surface->round);
    if (d->surface) d->kind = LSAMP_LIGHT_CALLBACK;
}

static void lsamp__emitter_geometry(lsamp_light *l)
{
    const lsamp_light_desc *d = &l->desc;
    lsamp__v3 u = lsamp__v3_load(d->u), v = lsamp__v3_load(d->v), n;
    float area2;

    l->origin = lsamp__v3_load(d->position);
    l->radiance = lsamp__v3_load(d->radiance);
    l->n = lsamp__v3_normalize(lsamp__v3_load(d->direction));
    l->cos_cone = d->kind == LSAMP_LIGHT_SPOT ? lsamp__cos(d->cone_half_angle) : 0.0f;
    l->turn = d->rotation / (2.0f * LSAMP__PI);
    l->area = 1.0f;
    memcpy(l->location, d->position, sizeof d->position);
    l->location[3] = 1.0f;
    if (d->kind == LSAMP_LIGHT_LINE) {
        l->n = lsamp__v3_normalize(u);
        l->lx = lsamp__v3_length(u);
    } else if (d->kind == LSAMP_LIGHT_DISC) {
        lsamp__v3_basis(l->n, &l->ex, &l->ey);
        l->area = LSAMP__PI * d->radius * d->radius;
    } else if (d->kind == LSAMP_LIGHT_SPHERE) {
        l->area = 4.0f * LSAMP__PI * d->radius * d->radius;
    } else if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        n = lsamp__v3_cross(u, v);
        l->area = lsamp__v3_length(n);
        l->n = lsamp__v3_normalize(n);
        l->lx = lsamp__v3_length(u);
        l->ly = lsamp__v3_length(v);
        area2 = 1.0f / l->area;
        l->ex = lsamp__v3_scale(lsamp__v3_cross(v, l->n), area2);
        l->ey = lsamp__v3_scale(lsamp__v3_cross(l->n, u), area2);
        l->orthogonal = fabsf(lsamp__v3_dot(u, v)) <= 1e-5f * l->area;
    }
}

/* Returns what lsamp_light_init returns, and logs why, for a desc for which lsamp_light_bytes returned 0. */
static lsamp_result lsamp__light_error(const lsamp_light_desc *d, const lsamp__logger *log)
{
    const lsamp_result result = lsamp__emitter_check(d, log);
    if (result != LSAMP_OK) return result;
    lsamp__log_text(log, "desc", "needs more memory than a size_t counts");
    return LSAMP_ERR_LIMIT;
}

static lsamp_result lsamp__refuse(const lsamp__logger *log, lsamp_result result, const char *field,
                                  const char *text)
{
    lsamp__log_text(log, field, text);
    return result;
}

LSAMP_DEF lsamp_result lsamp_light_init(const lsamp_light_desc *desc, void *memory, size_t memory_bytes,
                                         lsamp_light **out, uint64_t *bad_texels)
{
    size_t bytes = lsamp_light_bytes(desc);
    lsamp_light *l = (lsamp_light *)memory;
    uint64_t bad = 0;
    lsamp__logger log;

    if (!desc) return LSAMP_ERR_ARGUMENT;
    log = lsamp__logger_of(&desc->system, "lsamp_light_init");
    if (!memory) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "memory", "is NULL");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (!bytes) return lsamp__light_error(desc, &log);
    if ((uintptr_t)memory & 7u)
        return lsamp__refuse(&log, LSAMP_ERR_MEMORY, "memory", "is not aligned to 8 bytes");
    if (memory_bytes < bytes) {
        lsamp__log_bound(&log, "memory_bytes", memory_bytes, "at least", bytes, "lsamp_light_bytes(desc)");
        return LSAMP_ERR_MEMORY;
    }
    memset(l, 0, sizeof *l);
    l->desc = *desc;
    l->desc.texels = NULL;
    if (!desc->texels) l->desc.filter = LSAMP_TEXELS_NEAREST;   /* there is nothing to be linear between */
    lsamp__emitter_kind(l);
    lsamp__emitter_geometry(l);
    if (desc->kind == LSAMP_LIGHT_MESH) {
        lsamp__curve *curve;
        lsamp_result result = lsamp__curve_build(desc, (char *)memory + LSAMP__EMITTER_HEAD, &curve);
        if (result != LSAMP_OK) return lsamp__refuse(&log, result, "desc.mesh", "has no area");
        l->curve = curve;
        l->desc.kind = LSAMP_LIGHT_CALLBACK;
    }
    if (desc->texels || lsamp__is_environment(desc)) {
        static const float white[3] = { 1.0f, 1.0f, 1.0f };
        double *sums = (double *)(void *)((char *)memory + LSAMP__EMITTER_HEAD);
        float *texels, *row;
        uint32_t y;

        if (!desc->texels) {
            l->desc.width = l->desc.height = 1;
            l->desc.texels = white;
        } else {
            l->desc.texels = desc->texels;
        }
        if (lsamp__is_environment(desc)) {
            for (y = 0; y <= l->desc.height; y++) sums[y] = lsamp__row_edge(y, l->desc.height);
            l->edges = sums;
            sums += l->desc.height + 1u;
        }
        texels = (float *)(void *)(sums + lsamp__cdf2_doubles(l->desc.width, l->desc.height));
        bad = lsamp__emitter_frame(&l->desc, texels);
        l->desc.texels = texels;
        row = texels + (size_t)l->desc.width * l->desc.height * 3u;
        lsamp__emitter_cdf(l, sums, row, (uint16_t *)(void *)(row + l->desc.width));
    }
    if (bad_texels) *bad_texels = bad;
    *out = l;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_light_domain(const lsamp_light *light, lsamp_domain *out)
{
    static const lsamp_domain_kind kinds[10] = { LSAMP_DOMAIN_LATLONG,   LSAMP_DOMAIN_LATLONG,
                                                 LSAMP_DOMAIN_LATLONG,   LSAMP_DOMAIN_LIST,
                                                 LSAMP_DOMAIN_LIST,      LSAMP_DOMAIN_LINE,
                                                 LSAMP_DOMAIN_RECTANGLE, LSAMP_DOMAIN_DISC,
                                                 LSAMP_DOMAIN_SPHERE,    LSAMP_DOMAIN_TABLE };
    const lsamp_light_desc *d;
    lsamp__logger log;

    if (!light) return LSAMP_ERR_ARGUMENT;
    d = &light->desc;
    log = lsamp__logger_of(&d->system, "lsamp_light_domain");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (d->kind == LSAMP_LIGHT_CALLBACK && !light->curve)
        return lsamp__refuse(&log, LSAMP_ERR_MISMATCH, "light",
                             "is a callback or a surface, which has no domain of its own");
    memset(out, 0, sizeof *out);
    out->kind = kinds[d->kind];
    if (light->curve) {
        out->side[0] = light->curve->places;
        out->side[1] = out->side[2] = 1;
        out->locations = light->curve->locations;
        out->location_count = light->curve->places;
        return LSAMP_OK;
    }
    memcpy(out->origin, d->position, sizeof out->origin);
    memcpy(out->u, d->u, sizeof out->u);
    memcpy(out->v, d->v, sizeof out->v);
    if (d->kind == LSAMP_LIGHT_DISC) {
        lsamp__v3_store(out->u, lsamp__v3_scale(light->ex, d->radius));
        lsamp__v3_store(out->v, lsamp__v3_scale(light->ey, d->radius));
    } else if (d->kind == LSAMP_LIGHT_SPHERE) {
        lsamp__v3_store(out->u, lsamp__v3_make(d->radius, 0.0f, 0.0f));
    } else if (out->kind == LSAMP_DOMAIN_LIST) {
        out->locations = light->location;
        out->location_count = 1;
    }
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_surface_locations(const lsamp_surface *surface, uint32_t width, uint32_t height,
                                               float lift, float *locations)
{
    uint32_t i, j;

    if (!surface || !locations || !width || !height) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__surface_valid(NULL, surface) || !lsamp__finite(lift)) return LSAMP_ERR_INPUT;
    for (j = 0; j < height; j++)
        for (i = 0; i < width; i++, locations += 4) {
            const float x = ((float)i + 0.5f) / (float)width, y = ((float)j + 0.5f) / (float)height;
            float q[3], n[3], area;
            lsamp__surface_point(surface, x, y, q, n, &area);
            lsamp__v3_store(locations, lsamp__v3_madd(lsamp__v3_load(q),
                                                      lsamp__v3_normalize(lsamp__v3_load(n)), lift));
            locations[3] = 1.0f;
        }
    return LSAMP_OK;
}

LSAMP_DEF int lsamp_light_sample(const lsamp_light *light, const float p[3], const float u[3],
                                 lsamp_emission *out)
{
    lsamp__aim aim;
    lsamp_emission e;

    if (!light || !p || !u || !out || !lsamp__v3_finite(lsamp__v3_load(p)) || !lsamp__in3(u, 0.0f, 1.0f))
        return 0;
    if (!lsamp__aim_at(&aim, light, lsamp__v3_load(p)) || !lsamp__emitter_draw(&aim, u, &e)) return 0;
    *out = e;
    return 1;
}

LSAMP_DEF int lsamp_light_hit(const lsamp_light *light, const float p[3], const float direction[3],
                              lsamp_emission *out)
{
    lsamp__aim aim;
    lsamp_emission e;

    if (!light || !p || !direction || !out || !lsamp__v3_finite(lsamp__v3_load(p)) ||
        !lsamp__is_unit(direction))
        return 0;
    if (!lsamp__aim_at(&aim, light, lsamp__v3_load(p)) ||
        !lsamp__aim_hit(&aim, lsamp__v3_normalize(lsamp__v3_load(direction)), &e))
        return 0;
    *out = e;
    return 1;
}
