/* ---- building: what analytic lights and callbacks radiate ---- */

/* Writes what an analytic emitter radiates to the eye (in r, about the center) from a direction. */
static void sfield__sample_emitter(const sfield__build *b, const float *eye, const float *d, float *rgb)
{
    const sfield_emitter *e = &b->emitter;
    float r = b->h.radius, along = eye[0] * d[0] + eye[1] * d[1] + eye[2] * d[2], facing, t;
    float d2 = eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2], size = e->radius / r;
    uint32_t c;
    rgb[0] = rgb[1] = rgb[2] = 0;
    facing = -(e->normal[0] * d[0] + e->normal[1] * d[1] + e->normal[2] * d[2]);
    if (e->kind == SFIELD_EMITTER_CALLBACK) {
        float p[3];
        for (c = 0; c < 3; c++) p[c] = b->h.center[c] + r * eye[c];
        if (e->view_fn) e->view_fn(e->user, b->time, p, d, rgb);
        for (c = 0; c < 3; c++) {
            if (!(sfield__finite(rgb[c]) && rgb[c] > 0)) rgb[c] = 0;
            rgb[c] = rgb[c] < 1e18f ? rgb[c] : 1e18f;
        }
        return;
    }
    if (e->kind == SFIELD_EMITTER_SPHERE) {
        if (d2 > size * size && (along > 0 || d2 - along * along > size * size)) return;
        if ((e->normal[0] != 0 || e->normal[1] != 0 || e->normal[2] != 0) && facing < b->cosine) return;
    } else {
        const float unit = sfield__unit(r);
        float p[3], n[3], nl;
        sfield__v3 u = sfield__v3_scale(sfield__v3_load(e->u), unit),
                   w = sfield__v3_scale(sfield__v3_load(e->v), unit);
        sfield__v3 cross = sfield__v3_cross(u, w);
        if (e->kind == SFIELD_EMITTER_RECTANGLE) sfield__v3_store(n, sfield__v3_normalize(cross));
        else memcpy(n, e->normal, sizeof n);
        nl = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        t = -(n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2]) / (nl < 0 ? nl : -1e-30f);
        if (!(nl < 0) || !(t > 0) || !(t < 1e6f) || -nl < b->cosine) return;
        for (c = 0; c < 3; c++) p[c] = (eye[c] + t * d[c]) * r;
        if (e->kind == SFIELD_EMITTER_DISC) {
            if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > e->radius * e->radius) return;
        } else {
            sfield__v3 q = sfield__v3_scale(sfield__v3_load(p), unit);
            float uu = sfield__v3_dot(u, u), vv = sfield__v3_dot(w, w), uv = sfield__v3_dot(u, w);
            float pu = sfield__v3_dot(q, u), pv = sfield__v3_dot(q, w), det = uu * vv - uv * uv;
            if (fabsf(pu * vv - pv * uv) > det || fabsf(pv * uu - pu * uv) > det) return;
        }
    }
    memcpy(rgb, e->radiance, 3 * sizeof *rgb);
}

/* Samples analytic lights and callbacks, in those texels that the bounding sphere reaches. */
static void sfield__sample_cube(const sfield__build *b, sfield__view *v, const float *eye)
{
    uint32_t i, x, y;
    uint32_t c, face, tx;
    uint32_t ty, s = v->scale, n = b->h.cube_side;
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    float reach = d > 1.0001f ? sqrtf(1 - 1 / (d * d)) : -1, texel = 1.5f / (float)n;
    if (sfield__is_tube(&b->emitter)) {
        sfield__sample_tube(b, v, eye);
        return;
    }
    for (i = 0; i < b->cells; i++) {
        const float *to = b->texels.direction + 3 * i;
        float sum[3] = { 0, 0, 0 },
              cosine = d > 0 ? -(to[0] * eye[0] + to[1] * eye[1] + to[2] * eye[2]) / d : 1;
        /* cos(a - b) <= cos a + b: a texel's half diagonal is below 1.5 / N */
        if (cosine + texel < reach) continue;
        sfield__texel_place(n, i, &face, &tx, &ty);
        for (y = 0; y < s; y++)
            for (x = 0; x < s; x++) {
                double q[3], l;
                float dir[3], rgb[3];
                sfield__from_face(face, (2.0 * (tx * s + x) + 1) / (n * s) - 1,
                                  (2.0 * (ty * s + y) + 1) / (n * s) - 1, q);
                l = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
                for (c = 0; c < 3; c++) dir[c] = (float)(q[c] * l);
                sfield__sample_emitter(b, eye, dir, rgb);
                for (c = 0; c < b->h.channels; c++) sum[c] += rgb[c];
            }
        for (c = 0; c < b->h.channels; c++) v->texel[c * b->cells + i] = sum[c] / (float)(s * s);
    }
}

/* Returns the radius of the sphere about an emitter's centre that holds it; 0 if the emitter has no area, or
   no length. */
static float sfield__emitter_radius(const sfield_emitter *e)
{
    const sfield__v3 u = sfield__v3_load(e->u), v = sfield__v3_load(e->v);
    float x, y;
    if (sfield__is_tube(e)) {
        const float size = e->kind == SFIELD_EMITTER_LINE ? 0 : e->radius;
        x = sfield__v3_length(u);
        if (!(x > 0) || (e->kind == SFIELD_EMITTER_CYLINDER && !(size >= 1e-17f))) return 0;
        return sqrtf(x * x + size * size);
    }
    if (e->kind != SFIELD_EMITTER_RECTANGLE) return e->radius;
    x = sfield__v3_length(sfield__v3_add(u, v));
    y = sfield__v3_length(sfield__v3_sub(u, v));
    if (!(sfield__v3_length(sfield__v3_normalize(sfield__v3_cross(u, v))) > 0)) return 0;
    return x > y ? x : y;               /* of a side that is not finite neither: refused */
}

/* Takes the emitter's settings and, where it is to be fitted, the radius of the bounding sphere. */
static sfield_result sfield__take_emitter(sfield__build *b)
{
    static const char *const radiances[3] = { "emitter.radiance[0]", "emitter.radiance[1]",
                                              "emitter.radiance[2]" };
    sfield_emitter *e = &b->emitter;
    const int unit = sfield__unit_vector(e->normal),
              zero = e->normal[0] == 0 && e->normal[1] == 0 && e->normal[2] == 0;
    const char *shape = e->kind == SFIELD_EMITTER_RECTANGLE ? "half the diagonal of emitter.u and v"
                        : e->kind == SFIELD_EMITTER_LINE    ? "the length of emitter.u"
                        : sfield__is_tube(e)                ? "the sphere about emitter.u and radius"
                                                            : "emitter.radius";
    float fit, sine;
    uint32_t i;
    if (!sfield__check_value(&b->log, (uint32_t)e->kind < SFIELD_EMITTER_COUNT, "emitter.kind",
                             (double)e->kind, "0..6"))
        return SFIELD_ERR_DESC;
    if (e->kind == SFIELD_EMITTER_DEFAULT) e->kind = SFIELD_EMITTER_SPHERE;
    for (i = 0; i < 3; i++)
        if (!sfield__check_value(&b->log, sfield__in(e->radiance[i], 0, 1e18f), radiances[i],
                                 (double)e->radiance[i], "0..1e18"))
            return SFIELD_ERR_DESC;
    if (unit < 1 && (!zero || e->kind == SFIELD_EMITTER_DISC))
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "emitter.normal", "is not unit");
    if (!sfield__check_value(&b->log, sfield__in(e->cone_half_angle, 0, 3.14159274f),
                             "emitter.cone_half_angle", (double)e->cone_half_angle, "0..pi"))
        return SFIELD_ERR_DESC;
    b->cosine = 0;
    if (e->cone_half_angle > 0) sfield__sincos(e->cone_half_angle, &sine, &b->cosine);
    if (e->kind == SFIELD_EMITTER_CALLBACK) {
        if (!e->view_fn) return sfield__fail(&b->log, SFIELD_ERR_DESC, "emitter.view_fn", "is NULL");
        return sfield__need_radius(b);
    }
    fit = sfield__emitter_radius(e);
    if (!sfield__check_value(&b->log, sfield__in(fit, 1e-17f, 1e17f), shape, (double)fit, "1e-17..1e17"))
        return SFIELD_ERR_DESC;
    if (b->desc.radius == 0) b->h.radius = fit;
    if (!sfield__check_value(&b->log, b->h.radius >= fit * 0.999f, "desc.radius", (double)b->h.radius,
                      "0, or hold the emitter"))
        return SFIELD_ERR_DESC;
    return SFIELD_OK;
}
