/* ---- desc: checked, with defaults filled in ---- */

/* Fills in the sides that are 0, and refuses those that the kind cannot have. */
static cohsm_result cohsm__check_sides(cohsm_domain *d, const cohsm__logger *log)
{
    static const char *const name[3] = { "desc.domain.side[0]", "desc.domain.side[1]",
                                         "desc.domain.side[2]" };
    uint32_t *s = d->side, dims, i, fallback;
    uint64_t n = 1;

    if (d->kind == COHSM_DOMAIN_LIST) {
        if (d->location_count == 0 || d->location_count > 1u << 24)
            return cohsm__refuse_value(log, "desc.domain.location_count", (double)d->location_count,
                                       "1..2^24");
        s[0] = (uint32_t)d->location_count;
        s[1] = s[2] = 1;
        return COHSM_OK;
    }
    if (d->kind == COHSM_DOMAIN_TABLE)
        for (i = 0; i < 3; i++) s[i] = s[i] ? s[i] : 1u;
    dims = cohsm__dimensions(d->kind, s);
    fallback = dims == 3 ? 32u : 128u;
    for (i = 0; i < 3; i++) {
        if (i >= dims && s[i] > 1)
            return cohsm__refuse_value(log, name[i], (double)s[i], "0 or 1: the kind has fewer dimensions");
        if (!s[i]) s[i] = i < dims ? fallback : 1u;
        if (s[i] > 4096 && d->kind != COHSM_DOMAIN_TABLE)
            return cohsm__refuse_value(log, name[i], (double)s[i], "0, or 1..4096");
        n *= s[i];
        if (n > 1u << 24)
            return cohsm__refuse_value(log, name[i], (double)s[i],
                                       "less: sides may make 2^24 cells together");
    }
    if (d->kind == COHSM_DOMAIN_OCTAHEDRAL && s[0] != s[1])
        return cohsm__refuse_value(log, name[1], (double)s[1], "side[0]: an octahedral domain is a square");
    if (d->kind == COHSM_DOMAIN_TABLE && d->location_count != n)
        return cohsm__refuse_value(log, "desc.domain.location_count", (double)d->location_count,
                                   "the product of side");
    return COHSM_OK;
}

static cohsm_result cohsm__check_locations(const cohsm_domain *d, const cohsm__logger *log)
{
    static const char field[] = "desc.domain.locations";
    static const char *const coordinate[3] = { "has the x", "has the y", "has the z" };
    const float *p = d->locations;
    size_t i, k;

    if (!p) return cohsm__refuse(log, COHSM_ERR_DESC, field, "is NULL");
    for (i = 0; i < d->location_count; i++, p += 4) {
        if ((p[3] != 0.0f && p[3] != 1.0f) || p[3] != d->locations[3]) {
            cohsm__log_element(log, field, i, "has the w", (double)p[3], "0 for all or 1 for all");
            return COHSM_ERR_INPUT;
        }
        for (k = 0; k < 3; k++)
            if (!cohsm__finite(p[k])) {
                cohsm__log_element(log, field, i, coordinate[k], (double)p[k], "finite");
                return COHSM_ERR_INPUT;
            }
        if (p[3] == 0.0f && cohsm__v3_length(cohsm__v3_normalize(cohsm__v3_load(p))) == 0.0f) {
            cohsm__log_element(log, field, i, "has the length", 0.0, "more: with w = 0 it is a direction");
            return COHSM_ERR_INPUT;
        }
    }
    return COHSM_OK;
}

/* Refuses a vector of the desc with a component that is not finite. */
static cohsm_result cohsm__check_finite3(const float *p, const char *field, const cohsm__logger *log)
{
    int i;
    for (i = 0; i < 3; i++)
        if (!cohsm__finite(p[i])) return cohsm__refuse_value(log, field, (double)p[i], "finite");
    return COHSM_OK;
}

static cohsm_result cohsm__check_shape(const cohsm_domain *d, const cohsm__logger *log)
{
    cohsm__v3 u = cohsm__v3_load(d->u), v = cohsm__v3_load(d->v), w = cohsm__v3_load(d->w);
    cohsm_result result;

    if (cohsm__has_table((uint32_t)d->kind)) return cohsm__check_locations(d, log);
    if (d->kind == COHSM_DOMAIN_LATLONG || d->kind == COHSM_DOMAIN_OCTAHEDRAL) return COHSM_OK;
    result = cohsm__check_finite3(d->origin, "desc.domain.origin", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->u, "desc.domain.u", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->v, "desc.domain.v", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->w, "desc.domain.w", log);
    if (result != COHSM_OK) return result;
    if (!(cohsm__v3_length(u) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "has no length");
    if ((d->kind == COHSM_DOMAIN_RECTANGLE || d->kind == COHSM_DOMAIN_DISC) &&
        !(cohsm__v3_length(cohsm__v3_cross(u, v)) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "and v span no area");
    if (d->kind == COHSM_DOMAIN_VOLUME && !(fabsf(cohsm__v3_dot(cohsm__v3_cross(u, v), w)) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "and v and w span no volume");
    return COHSM_OK;
}

static cohsm_result cohsm__check_kinds(cohsm_desc *d, const cohsm__logger *log)
{
    if (!cohsm__system_valid(&d->system)) {
        cohsm__log_text(log, "desc.system.allocator", "has one function of the two");
        return COHSM_ERR_DESC;
    }
    if ((unsigned)d->domain.kind >= COHSM_DOMAIN_COUNT)
        return cohsm__refuse_value(log, "desc.domain.kind", (double)d->domain.kind, "a COHSM_DOMAIN_...");
    if ((unsigned)d->layers >= COHSM_LAYERS_COUNT)
        return cohsm__refuse_value(log, "desc.layers", (double)d->layers, "a COHSM_LAYERS_...");
    if ((unsigned)d->order >= COHSM_ORDER_COUNT)
        return cohsm__refuse_value(log, "desc.order", (double)d->order, "a COHSM_ORDER_...");
    if ((unsigned)d->orientation >= COHSM_ORIENTATION_COUNT)
        return cohsm__refuse_value(log, "desc.orientation", (double)d->orientation,
                                   "a COHSM_ORIENTATION_...");
#ifdef COHSM_WITHOUT_FAST
    if (d->layout == COHSM_LAYOUT_FAST)
        return cohsm__refuse_value(log, "desc.layout", (double)d->layout,
                                   "another one in a header without fast");
#endif
    if ((unsigned)d->layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse_value(log, "desc.layout", (double)d->layout, "a COHSM_LAYOUT_...");
    if (d->domain.kind == COHSM_DOMAIN_DEFAULT) d->domain.kind = COHSM_DOMAIN_LATLONG;
    if (d->layers == COHSM_LAYERS_DEFAULT) d->layers = COHSM_LAYERS_Z1Z2;
    return COHSM_OK;
}

/* Checks a desc and fills in its defaults; order and sphere may stay open until the mesh is known. */
static cohsm_result cohsm__check_desc(cohsm_desc *d, const cohsm__logger *log)
{
    cohsm_result result;
    uint32_t pixels;

    if (cohsm__check_kinds(d, log) != COHSM_OK) return COHSM_ERR_DESC;
    if (!d->map_side) d->map_side = 128;
    if (!d->depth_bits) d->depth_bits = 8;
    if (!(d->open_thickness >= 0.0f))
        return cohsm__refuse_value(log, "desc.open_thickness", (double)d->open_thickness, "0 or more");
    if (d->open_thickness == 0.0f) d->open_thickness = 8.0f;
    if (d->open_thickness > (float)d->map_side) d->open_thickness = (float)d->map_side;
    if (d->map_side < 4 || d->map_side > 1024)
        return cohsm__refuse_value(log, "desc.map_side", (double)d->map_side, "0, or 4..1024");
    if (d->depth_bits < 4 || d->depth_bits > 8)
        return cohsm__refuse_value(log, "desc.depth_bits", (double)d->depth_bits, "0, or 4..8");
    if (cohsm__check_sides(&d->domain, log) != COHSM_OK) return COHSM_ERR_DESC;
    result = cohsm__check_shape(&d->domain, log);
    if (result != COHSM_OK) return result;
    if (d->domain.kind == COHSM_DOMAIN_LIST || d->domain.kind == COHSM_DOMAIN_LINE)
        d->order = COHSM_ORDER_SCANLINE;
    if (cohsm__check_finite3(d->center, "desc.center", log) != COHSM_OK) return COHSM_ERR_DESC;
    if (!cohsm__finite(d->radius) || d->radius < 0.0f)
        return cohsm__refuse_value(log, "desc.radius", (double)d->radius, "0 or more, and finite");
    pixels = d->map_side * d->map_side;
    if (!d->pixel_begin && !d->pixel_end) d->pixel_end = pixels;
    if (d->pixel_begin < d->pixel_end && d->pixel_end <= pixels) return COHSM_OK;
    return cohsm__refuse_value(log, "desc.pixel_end", (double)d->pixel_end,
                               "above pixel_begin, and map_side^2 or less");
}

/* Logs why a build failed, if it did though its desc and mesh were right. Returns the result. */
static cohsm_result cohsm__log_build(const cohsm__logger *log, const cohsm_desc *d, cohsm_result result)
{
    if (result == COHSM_ERR_LIMIT)
        cohsm__log_value(log, "desc.map_side", (double)d->map_side,
                         "less, or domain.side: maps of 4 GiB or more cannot be made");
    if (result == COHSM_ERR_DESC)
        cohsm__log_text(log, "desc.domain", "lies so far away that depths are not finite");
    return cohsm__log_result(log, result);
}

/* Says whether a radius is far enough from the ends of the float range for squares and inverses. */
static int cohsm__radius_usable(float r) { return r > 1e-18f && r < 1e18f; }

static int cohsm__is_positional(const cohsm_domain *d)
{
    if (cohsm__has_table((uint32_t)d->kind)) return d->locations[3] != 0.0f;
    return d->kind != COHSM_DOMAIN_LATLONG && d->kind != COHSM_DOMAIN_OCTAHEDRAL;
}

static void cohsm__fill_header(cohsm__header *h, const cohsm_desc *d)
{
    memset(h, 0, sizeof *h);
    h->magic = COHSM__MAGIC;
    h->format = COHSM__FORMAT;
    h->domain = (uint32_t)d->domain.kind;
    h->layers = (uint32_t)d->layers;
    h->order = (uint32_t)d->order;
    h->orientation = (uint32_t)d->orientation;
    memcpy(h->side, d->domain.side, sizeof h->side);
    h->map_count = h->side[0] * h->side[1] * h->side[2];
    h->positional = (uint32_t)cohsm__is_positional(&d->domain);
    h->view_count = h->map_count * (h->positional ? 6u : 1u);
    h->map_side = d->map_side;
    h->depth_bits = d->depth_bits;
    h->open_thickness = d->open_thickness;
    h->dimensions = cohsm__dimensions(d->domain.kind, h->side);
    h->self_only = d->self_only != 0;
    h->pixel_begin = d->pixel_begin;
    h->pixel_end = d->pixel_end;
    if (d->order == COHSM_ORDER_HILBERT)
        h->order_words = h->map_count <= 65536 ? (h->map_count + 1) / 2 : h->map_count;
    if (cohsm__has_table(h->domain)) h->location_words = 4 * h->map_count;
    memcpy(h->center, d->center, sizeof h->center);
    h->radius = d->radius;
    if (!cohsm__has_table(h->domain) && h->positional) {
        memcpy(h->origin, d->domain.origin, sizeof h->origin);
        memcpy(h->u, d->domain.u, sizeof h->u);
        memcpy(h->v, d->domain.v, sizeof h->v);
        memcpy(h->w, d->domain.w, sizeof h->w);
    }
}

static uint32_t cohsm__chunks(const cohsm__header *h) { return (h->view_count - 1u) / COHSM__CHUNK + 1u; }

/* Returns the distance that depth 1 stands for in maps of positions: as far as anything of the object is from
   any location. */
static float cohsm__far_distance(const cohsm__header *h, const float *locations)
{
    cohsm__v3 c = cohsm__v3_load(h->center);
    float farthest = 0.0f, d;
    uint32_t i;
    for (i = 0; i < h->map_count; i++) {
        d = cohsm__v3_length(cohsm__v3_sub(cohsm__cell_location(h, locations, i), c));
        if (d > farthest) farthest = d;
    }
    return (farthest + h->radius) * 1.0001f;
}

static cohsm__camera cohsm__camera_of(const cohsm__header *h, const float *locations, const float *angles,
                                      uint32_t cell, uint32_t face)
{
    cohsm__camera cam;
    memset(&cam, 0, sizeof cam);
    cam.perspective = h->positional != 0;
    if (cam.perspective) {
        cam.face = face;
        cam.eye = cohsm__v3_sub(cohsm__cell_location(h, locations, cell), cohsm__v3_load(h->center));
        cam.eye = cohsm__v3_scale(cam.eye, 1.0f / h->radius);
        cam.depth_scale = h->radius / h->depth_far;
    } else cam.axes = cohsm__cell_axes(h, locations, angles, cell);
    return cam;
}

/* Returns the depth at which the ray through a pixel's centre leaves the bounding sphere. */
static uint16_t cohsm__leave_depth(const cohsm__camera *cam, uint32_t size, uint32_t pixel)
{
    float x = ((float)(pixel % size) + 0.5f) / (float)size * 2.0f - 1.0f;
    float y = ((float)(pixel / size) + 0.5f) / (float)size * 2.0f - 1.0f;
    float a, b, c, disc;
    cohsm__v3 e = cam->eye;
    float ex, ey, ew;

    if (!cam->perspective) {
        disc = 1.0f - x * x - y * y;
        return cohsm__depth16(0.5f + 0.5f * sqrtf(disc > 0.0f ? disc : 0.0f));
    }
    cohsm__face_coordinates(cam->face, e, &ex, &ey, &ew);
    a = x * x + y * y + 1.0f;
    b = ex * x + ey * y + ew;
    c = ex * ex + ey * ey + ew * ew - 1.0f;
    disc = b * b - a * c;
    if (!(disc > 0.0f)) return 0;
    return cohsm__depth16((sqrtf(disc) - b) / a * cam->depth_scale);
}
