/* ---- shapes: a point of each shape drawn, and found along a ray ---- */

/* Writes how a point sees an environment in direction w, which lies in texel x, y at the coordinates u, v.
   Rows go by the cosines of their edges, so that solid angles are exact (T12). Returns 0 if the texel is
   black. */
static int lsamp__environment_found(const lsamp_light *l, uint32_t x, uint32_t y, float u, float v,
                                    lsamp__v3 w, lsamp_emission *out)
{
    lsamp__v3 mean = lsamp__texel_mean(l, x, y), texel = mean;

    if (l->desc.filter == LSAMP_TEXELS_LINEAR)
        texel = lsamp__texel_at(l, lsamp__clamp_unit(u), lsamp__clamp_unit(v));
    u -= l->turn;
    out->coords[0] = lsamp__clamp_unit(u - floorf(u));
    out->coords[1] = lsamp__clamp_unit(v);
    out->distance = LSAMP_INFINITY;
    out->pdf = lsamp__v3_dot(mean, l->tint);
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, texel, 1.0f, w, out) && out->pdf > 0.0f;
}

static int lsamp__environment_draw(const lsamp_light *l, const float *u, lsamp_emission *out)
{
    float x, y, r;
    float sn, cs;
    float fx, fy;
    uint32_t i, j;

    if (!lsamp__pick_cell(l, u, &i, &j, &fx, &fy)) return 0;
    x = ((float)i + fx) / (float)l->desc.width;
    y = (float)(l->edges[j] + (l->edges[j + 1u] - l->edges[j]) * (double)fy);
    r = lsamp__safe_sqrt((1.0f - y) * (1.0f + y));
    lsamp__sincos(2.0f * LSAMP__PI * (x - l->turn - 0.5f), &sn, &cs);
    return lsamp__environment_found(l, i, j, x, lsamp__acos(y) / LSAMP__PI,
                                    lsamp__v3_make(r * cs, y, r * sn), out);
}

static int lsamp__environment_hit(const lsamp_light *l, lsamp__v3 w, lsamp_emission *out)
{
    float u = 0.5f + lsamp__atan2(w.z, w.x) / (2.0f * LSAMP__PI) + l->turn, v = lsamp__acos(w.y) / LSAMP__PI;
    u -= floorf(u);
    return lsamp__environment_found(l, lsamp__cell_of(u, l->desc.width), lsamp__cell_of(v, l->desc.height), u,
                                    v, w, out);
}

/* Prepares the sampling of a rectangle by solid angle: Urena, Fajardo and King, "An area-preserving
   parametrization for spherical rectangles", EGSR 2013. In floats this needs a solid angle that is not small;
   smaller rectangles are sampled by area, which is no worse there. */
static void lsamp__rectangle_aim(lsamp__aim *a)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p);
    float n0, n1, n2, n3;
    float g0, g1, g2, g3;
    float z2;

    a->x0 = lsamp__v3_dot(d, l->ex) * l->lx;
    a->y0 = lsamp__v3_dot(d, l->ey) * l->ly;
    a->x1 = a->x0 + l->lx;
    a->y1 = a->y0 + l->ly;
    a->z = lsamp__v3_dot(d, l->n);   /* below 0: p is on the side that emits */
    z2 = a->z * a->z;
    n0 = -a->y0 / sqrtf(z2 + a->y0 * a->y0);
    n1 = a->x1 / sqrtf(z2 + a->x1 * a->x1);
    n2 = a->y1 / sqrtf(z2 + a->y1 * a->y1);
    n3 = -a->x0 / sqrtf(z2 + a->x0 * a->x0);
    g0 = lsamp__acos(-n0 * n1);
    g1 = lsamp__acos(-n1 * n2);
    g2 = lsamp__acos(-n2 * n3);
    g3 = lsamp__acos(-n3 * n0);
    a->b0 = n0;
    a->b1 = n2;
    a->k = 2.0f * LSAMP__PI - g2 - g3;
    a->solid = g0 + g1 - a->k;
    if (a->solid > 0.05f && lsamp__finite(a->solid)) a->solid_pdf = 1.0f / a->solid;
}

/* Returns the solid angle of a flat shape of this area and normal about d: right far away, at most 2 pi close
   by. */
static float lsamp__flat_solid(lsamp__v3 n, lsamp__v3 d, float area)
{
    float d2 = lsamp__v3_dot(d, d), cosine = fabsf(lsamp__v3_dot(n, d)) / sqrtf(d2 > 0.0f ? d2 : 1.0f);
    float near2 = area * (1.0f / (2.0f * LSAMP__PI));
    return area * (cosine * d2 + near2) / ((d2 + near2) * (d2 + near2));
}

static void lsamp__rectangle_pick(const lsamp__aim *a, const float *u, float *x, float *y)
{
    float au = u[0] * a->solid + a->k, sn, cs;
    float f, c, d;
    float xu, yv;
    float h0, h1, h;

    lsamp__sincos(au, &sn, &cs);
    f = (cs * a->b0 - a->b1) / sn;
    c = 1.0f / sqrtf(f * f + a->b0 * a->b0);
    c = f > 0.0f ? c : -c;
    c = c > -1.0f ? c < 1.0f ? c : 1.0f : -1.0f;
    xu = -(c * a->z) / sqrtf(1.0f - c * c > 1e-12f ? 1.0f - c * c : 1e-12f);
    xu = xu > a->x0 ? xu < a->x1 ? xu : a->x1 : a->x0;
    d = sqrtf(xu * xu + a->z * a->z);
    h0 = a->y0 / sqrtf(d * d + a->y0 * a->y0);
    h1 = a->y1 / sqrtf(d * d + a->y1 * a->y1);
    h = h0 + u[1] * (h1 - h0);
    yv = h * h < 1.0f - 1e-6f ? h * d / sqrtf(1.0f - h * h) : a->y1;
    *x = (xu - a->x0) / (a->x1 - a->x0);
    *y = (yv - a->y0) / (a->y1 - a->y0);
}

/* Computes the members of an aim, which depend on light and point alone. Returns 0 if the light does not
   reach p. */
static int lsamp__aim_at(lsamp__aim *a, const lsamp_light *l, lsamp__v3 p)
{
    lsamp__v3 d = lsamp__v3_sub(l->origin, p);
    float r = l->desc.radius, s;

    memset(a, 0, sizeof *a);
    a->light = l;
    a->p = p;
    switch (l->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
        if (!(lsamp__v3_dot(l->n, d) < 0.0f)) return 0;
        if (l->orthogonal && !l->desc.texels) lsamp__rectangle_aim(a);
        if (a->solid_pdf > 0.0f) return 1;
        d = lsamp__v3_madd(d, lsamp__v3_add(lsamp__v3_load(l->desc.u), lsamp__v3_load(l->desc.v)), 0.5f);
        a->solid = lsamp__flat_solid(l->n, d, l->area);
        return 1;
    case LSAMP_LIGHT_DISC:
        a->solid = lsamp__flat_solid(l->n, d, l->area);
        return lsamp__v3_dot(l->n, d) < 0.0f;
    case LSAMP_LIGHT_SPHERE:
        a->distance = lsamp__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = lsamp__v3_scale(d, 1.0f / a->distance);
        s = (r / a->distance) * (r / a->distance);
        a->spread = s / (1.0f + sqrtf(1.0f - s));
        a->solid = 2.0f * LSAMP__PI * a->spread;
        if (!l->desc.texels && a->spread > 0.0f) a->solid_pdf = 1.0f / a->solid;
        return 1;
    case LSAMP_LIGHT_LINE:
        s = lsamp__v3_dot(d, l->n);
        d = lsamp__v3_sub(lsamp__v3_scale(l->n, s), d);
        a->distance = lsamp__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = lsamp__v3_scale(d, 1.0f / a->distance);
        a->spread = lsamp__safe_sqrt(1.0f - (r / a->distance) * (r / a->distance));
        d = lsamp__v3_make(a->distance, s, s + l->lx);   /* the line seen edge to edge: sines of its ends */
        a->solid = 2.0f * r / d.x * (d.z / sqrtf(d.x * d.x + d.z * d.z) - d.y / sqrtf(d.x * d.x + d.y * d.y));
        return 1;
    default:
        return 1;
    }
}

/* Returns the point A(x, y) of a shape that is flat or round; of a line, a point of its axis. */
static lsamp__v3 lsamp__shape_point(const lsamp_light *l, float x, float y)
{
    float dx, dy, sn, cs;
    float r = l->desc.radius;
    lsamp__v3 a, b;

    switch (l->desc.kind) {
    case LSAMP_LIGHT_LINE:
        return lsamp__v3_madd(l->origin, l->n, x * l->lx);
    case LSAMP_LIGHT_RECTANGLE:
        a = lsamp__v3_scale(lsamp__v3_load(l->desc.u), x);
        b = lsamp__v3_scale(lsamp__v3_load(l->desc.v), y);
        return lsamp__v3_add(l->origin, lsamp__v3_add(a, b));
    case LSAMP_LIGHT_DISC:
        lsamp__concentric(x, y, &dx, &dy);
        a = lsamp__v3_add(lsamp__v3_scale(l->ex, dx), lsamp__v3_scale(l->ey, dy));
        return lsamp__v3_madd(l->origin, a, r);
    case LSAMP_LIGHT_SPHERE:
        dy = 1.0f - 2.0f * y;
        dx = lsamp__safe_sqrt(1.0f - dy * dy);
        lsamp__sincos(2.0f * LSAMP__PI * (x - 0.5f), &sn, &cs);
        return lsamp__v3_madd(l->origin, lsamp__v3_make(dx * cs, dy, dx * sn), r);
    default:
        return l->origin;
    }
}

/* Writes how p sees a line's cylinder at x along the axis and at an angle about it, whose sine is given.
   Sines are spread evenly over the breadth that p sees, by which the lamp's own cosine drops out. Returns 0
   if no light reaches p. */
static int lsamp__line_at(const lsamp__aim *a, float x, float sine, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float cosine = lsamp__safe_sqrt(1.0f - sine * sine);
    lsamp__v3 n = lsamp__v3_scale(a->axis, cosine), q;

    n = lsamp__v3_madd(n, lsamp__v3_cross(l->n, a->axis), sine);
    q = lsamp__v3_madd(lsamp__shape_point(l, x, 0.0f), n, l->desc.radius);
    return lsamp__emit_area(a, q, n, x, 0.0f, lsamp__texel_density(l, x, 0.0f) * cosine /
                                                  (2.0f * a->spread * l->desc.radius * l->lx), out);
}

static int lsamp__sphere_at(const lsamp__aim *a, lsamp__v3 n, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float x = 0.5f + lsamp__atan2(n.z, n.x) / (2.0f * LSAMP__PI), y = 0.5f * (1.0f - n.y);
    x = lsamp__clamp_unit(x);
    y = lsamp__clamp_unit(y);
    return lsamp__emit_area(a, lsamp__v3_madd(l->origin, n, l->desc.radius), n, x, y,
                            lsamp__texel_density(l, x, y) / l->area, out);
}

static int lsamp__sphere_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float r = l->desc.radius;
    float x, y, sn, cs;
    float c, s2, along, reach;
    lsamp__v3 t, b, n;

    if (!(a->solid_pdf > 0.0f)) {
        lsamp__pick_point(l, u, &x, &y);
        n = lsamp__v3_sub(lsamp__shape_point(l, x, y), l->origin);
        return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
    }
    /* The direction lies in the cone about the axis; the normal where the ray meets the sphere follows from
       the law of sines. */
    c = u[0] * a->spread;
    s2 = c * (2.0f - c);
    c = 1.0f - c;
    reach = lsamp__safe_sqrt(r * r - a->distance * a->distance * s2);
    along = a->distance * s2 + c * reach;       /* from the centre towards p */
    x = lsamp__safe_sqrt(s2) * (a->distance * c - reach) / r;
    lsamp__sincos(2.0f * LSAMP__PI * u[1], &sn, &cs);
    lsamp__v3_basis(a->axis, &t, &b);
    n = lsamp__from_axes(t, b, a->axis, lsamp__v3_make(x * cs, x * sn, -along / r));
    return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
}

static int lsamp__delta_draw(const lsamp__aim *a, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p), w = l->n;
    float distance = lsamp__v3_length(d), scale = 1.0f;

    out->pdf = 1.0f;
    out->distance = LSAMP_INFINITY;
    if (l->desc.kind != LSAMP_LIGHT_SUN) {
        if (!(distance > 0.0f) || !lsamp__finite(distance)) return 0;
        w = lsamp__v3_scale(d, 1.0f / distance);
        if (l->desc.kind == LSAMP_LIGHT_SPOT && -lsamp__v3_dot(w, l->n) < l->cos_cone) return 0;
        scale = 1.0f / (distance * distance);
        out->distance = distance;
    }
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, lsamp__v3_make(scale, scale, scale), 1.0f, lsamp__v3_scale(w, -1.0f), out);
}

/* Writes the point of a surface at x, y, its normal, and d area / dx dy there. */
static void lsamp__surface_point(const lsamp_surface *s, float x, float y, float q[3], float n[3],
                                 float *area)
{
    const uint32_t columns = s->width - (s->round ? 0u : 1u), rows = s->height - 1u;
    const uint32_t i = lsamp__cell_of(x, columns), j = lsamp__cell_of(y, rows);
    const uint32_t next = i + 1u < s->width ? i + 1u : 0u;
    const float fx = x * (float)columns - (float)i, fy = y * (float)rows - (float)j;
    const float *row = s->points + 3u * (size_t)j * s->width, *after = row + 3u * (size_t)s->width;
    const lsamp__v3 a = lsamp__v3_load(row + 3u * (size_t)i), b = lsamp__v3_load(row + 3u * (size_t)next);
    const lsamp__v3 c = lsamp__v3_load(after + 3u * (size_t)i), d = lsamp__v3_load(after + 3u * (size_t)next);
    const lsamp__v3 top = lsamp__v3_sub(b, a), bottom = lsamp__v3_sub(d, c);
    const lsamp__v3 left = lsamp__v3_sub(c, a), right = lsamp__v3_sub(d, b);
    const lsamp__v3 along = lsamp__v3_madd(lsamp__v3_scale(top, 1.0f - fy), bottom, fy);
    const lsamp__v3 across = lsamp__v3_madd(lsamp__v3_scale(left, 1.0f - fx), right, fx);
    const lsamp__v3 normal = lsamp__v3_cross(lsamp__v3_scale(along, (float)columns),
                                             lsamp__v3_scale(across, (float)rows));
    lsamp__v3_store(q, lsamp__v3_madd(lsamp__v3_madd(a, top, fx), across, fy));
    lsamp__v3_store(n, normal);
    *area = lsamp__v3_length(normal);
}

static int lsamp__callback_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float q[3] = { 0.0f, 0.0f, 0.0f }, n[3] = { 0.0f, 0.0f, 0.0f };
    float area = 0.0f, x, y;

    lsamp__pick_point(l, u, &x, &y);
    out->coords[0] = x;
    out->coords[1] = y;
    out->coords[2] = l->desc.surface ? 0.0f : u[2];
    if (l->curve) lsamp__curve_point(l->curve, out->coords, q, n, &area);
    else if (l->desc.surface) lsamp__surface_point(l->desc.surface, x, y, q, n, &area);
    else l->desc.shape_fn(l->desc.user, l->desc.time, out->coords, q, n, &area);
    if (!lsamp__v3_finite(lsamp__v3_load(q)) || !lsamp__v3_finite(lsamp__v3_load(n)) ||
        !lsamp__finite(area) || !(area > 0.0f))
        return 0;
    return lsamp__emit_area(a, lsamp__v3_load(q), lsamp__v3_normalize(lsamp__v3_load(n)), x, y,
                            lsamp__texel_density(l, x, y) / area, out);
}

static int lsamp__emitter_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float x, y;

    memset(out, 0, sizeof *out);
    switch (l->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
    case LSAMP_LIGHT_DISC:
        if (a->solid_pdf > 0.0f) lsamp__rectangle_pick(a, u, &x, &y);
        else lsamp__pick_point(l, u, &x, &y);
        return lsamp__emit_area(a, lsamp__shape_point(l, x, y), l->n, x, y,
                                lsamp__texel_density(l, x, y) / l->area, out);
    case LSAMP_LIGHT_SPHERE:
        return lsamp__sphere_draw(a, u, out);
    case LSAMP_LIGHT_LINE:
        lsamp__pick_point(l, u, &x, &y);
        return lsamp__line_at(a, x, (2.0f * u[1] - 1.0f) * a->spread, out);
    case LSAMP_LIGHT_CALLBACK:
        return lsamp__callback_draw(a, u, out);
    case LSAMP_LIGHT_SUN:
    case LSAMP_LIGHT_POINT:
    case LSAMP_LIGHT_SPOT:
        return lsamp__delta_draw(a, out);
    default:
        return lsamp__environment_draw(l, u, out);
    }
}

/* Finds where a ray meets a rectangle or disc. Returns 0 if the ray sees no light. */
static int lsamp__plane_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(a->p, l->origin), q;
    float slope = -lsamp__v3_dot(l->n, w), height = lsamp__v3_dot(l->n, d), x, y;

    if (!(slope > 1e-7f) || !(height > 0.0f)) return 0;
    d = lsamp__v3_madd(d, w, height / slope);
    q = lsamp__v3_add(l->origin, d);
    x = lsamp__v3_dot(d, l->ex);
    y = lsamp__v3_dot(d, l->ey);
    if (l->desc.kind == LSAMP_LIGHT_DISC) {
        x /= l->desc.radius;
        y /= l->desc.radius;
        if (!(x * x + y * y < 1.0f)) return 0;
        lsamp__disc_square(x, y, &x, &y);
    } else if (!(x >= 0.0f && x < 1.0f && y >= 0.0f && y < 1.0f)) {
        return 0;
    }
    return lsamp__emit_area(a, q, l->n, x, y, lsamp__texel_density(l, x, y) / l->area, out);
}

/* Finds where a ray meets a sphere or line: the nearer root, measured from the foot of the perpendicular,
   which keeps its digits. Returns 0 if the ray sees no light. */
static int lsamp__round_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p), v = w, n;
    float r = l->desc.radius;
    float along, s, x, len2;

    if (l->desc.kind == LSAMP_LIGHT_LINE) {     /* across its axis, a line is a circle */
        d = lsamp__v3_scale(a->axis, -a->distance);
        v = lsamp__v3_madd(w, l->n, -lsamp__v3_dot(w, l->n));
    }
    len2 = lsamp__v3_dot(v, v);
    if (!(len2 > 1e-14f)) return 0;
    along = lsamp__v3_dot(d, v) / len2;
    n = lsamp__v3_sub(lsamp__v3_scale(v, along), d);
    s = r * r - lsamp__v3_dot(n, n);
    if (!(along > 0.0f) || !(s > 0.0f)) return 0;
    s = sqrtf(s / len2);
    n = lsamp__v3_scale(lsamp__v3_madd(n, v, -s), 1.0f / r);
    if (l->desc.kind == LSAMP_LIGHT_SPHERE) return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
    x = lsamp__v3_dot(lsamp__v3_madd(lsamp__v3_sub(a->p, l->origin), w, along - s), l->n) / l->lx;
    if (!(x >= 0.0f && x < 1.0f)) return 0;
    return lsamp__line_at(a, x, lsamp__v3_dot(n, lsamp__v3_cross(l->n, a->axis)), out);
}

static int lsamp__aim_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    memset(out, 0, sizeof *out);
    switch (a->light->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
    case LSAMP_LIGHT_DISC:
        return lsamp__plane_hit(a, w, out);
    case LSAMP_LIGHT_SPHERE:
    case LSAMP_LIGHT_LINE:
        return lsamp__round_hit(a, w, out);
    case LSAMP_LIGHT_DEFAULT:
    case LSAMP_LIGHT_ENVIRONMENT:
        return lsamp__environment_hit(a->light, w, out);
    default:
        return 0;
    }
}
