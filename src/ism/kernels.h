/* ---- kernels: light from one VPL or near point to a receiver, unshadowed ---- */

typedef struct ism__shade_work {
    const ism_maps    *m;
    const ism__view    *view;
    ism_shading        s;
    uint32_t           interleave, blocks_x;
    const uint32_t    *order;       /* numbers of the VPLs, class by class */
    const uint32_t    *class_first; /* where in `order` each of the interleave^2 classes begins; the end */
    const float       *fields;      /* ISM__FIELDS arrays of vpl_count, in `order` */
    const ism__orientation *axes;   /* axes of the VPLs' maps, in `order` */
    float             *light;       /* irradiance, 3 a pixel */
    float             *blurred;     /* the same after the blur */
    double            *lost;        /* four of each block: light that the rule near by took off, light before
                                       that, pairs that were culled, all pairs */
} ism__shade_work;

typedef struct ism__pixel { ism__v3 p, n, ng; } ism__pixel;

/* Returns the light of a unit of flux from a square of the VPL's area about the VPL. The square is cut at the
   receiver's horizon, and the part that is left sends the whole flux, since a surface does not go on behind
   the one it meets. A receiver that faces the square (fully from 120 degrees between the normals on) gets no
   more than from a point: it may be the back of a bent sheet close above the lit surface, to which the square
   reaches out, and depths cannot tell the two apart. *square is the light without this rule. */
static float ism__patch_kernel(const ism__orientation *f, ism__v3 d, ism__v3 n, float edge, float point,
                               float *square)
{
    ism__v3 c[4], x = ism__v3_scale(f->x, 0.5f * edge), y = ism__v3_scale(f->y, 0.5f * edge);
    float share, form, facing = -2.0f * ism__v3_dot(n, f->z);
    c[0] = ism__v3_sub(ism__v3_sub(d, x), y);
    c[1] = ism__v3_sub(ism__v3_add(d, x), y);
    c[2] = ism__v3_add(ism__v3_add(d, x), y);
    c[3] = ism__v3_add(ism__v3_sub(d, x), y);
    form = ism__form_factor(n, c, 4, &share);
    *square = form = form > 0.0f && share > 0.0f ? form * ISM__PI / (edge * edge * share) : 0.0f;
    if (!(facing > 0.0f) || !(form > point)) return form;
    return form + (facing < 1.0f ? facing : 1.0f) * (point - form);
}

/* Returns the light of a unit of flux from a virtual spherical light: the mean of both cosines over the cone
   that the sphere fills, whose radius is that of a disc of the VPL's area. After Hasan et al., "Virtual
   spherical lights for many-light rendering of glossy scenes", 2009. */
static float ism__sphere_kernel(ism__v3 d, ism__v3 normal, ism__v3 n, float edge)
{
    float r2 = edge * edge * (1.0f / ISM__PI), d2 = ism__v3_dot(d, d), least, sum = 0.0f;
    ism__v3 z = ism__v3_normalize(d), x, y;
    uint32_t k;
    least = d2 > r2 ? sqrtf(1.0f - r2 / d2) : -1.0f;
    ism__v3_basis(z, &x, &y);
    for (k = 0; k < 16u; k++) {
        float cosine = 1.0f - (1.0f - least) * ((float)k + 0.5f) * (1.0f / 16.0f),
              sine = sqrtf(1.0f - cosine * cosine);
        float s, c, a, b;
        ism__v3 w;
        ism__sincos(2.39996323f * (float)k, &s, &c);
        w = ism__v3_madd(ism__v3_madd(ism__v3_scale(z, cosine), x, sine * c), y, sine * s);
        a = ism__v3_dot(n, w);
        b = -ism__v3_dot(normal, w);
        if (a > 0.0f && b > 0.0f) sum += a * b;
    }
    return sum * (1.0f / 16.0f) * 2.0f * (1.0f - least) / r2;      /* / (pi r^2) x solid angle */
}

/* Returns which share of the light at this distance comes from near points: all of it within 0.7 reach,
   nothing beyond reach. */
static float ism__nearness(float d2, float reach)
{
    float r2 = reach * reach, h = 2.0f * (r2 - d2);
    return !(h > 0.0f) ? 0.0f : h < r2 ? h / r2 : 1.0f;
}

/* Returns cos cos / d^2 of one VPL, of a direction the cosine, with its lobe and the rule for receivers close
   by. *plain is the same without the light that this rule takes off. */
static float ism__kernel(const ism__shade_work *w, const ism_vpl *v, const ism__orientation *f,
                         const ism__pixel *px, float plain_kernel, float *plain)
{
    ism__v3 d = ism__v3_sub(ism__v3_load(v->position), px->p);
    float d2 = ism__v3_dot(d, d), k = plain_kernel, a2 = v->edge * v->edge, share;
    if (v->directional) {
        k = ism__v3_dot(ism__v3_load(v->position), px->n) * ISM__PI;    /* light is divided by pi
                                                                           afterwards */
        return *plain = k > 0.0f ? k : 0.0f;
    }
    if (v->exponent != 1.0f) {
        float length = sqrtf(d2), c = -ism__v3_dot(ism__v3_load(v->axis), d) / length,
              b = ism__v3_dot(px->n, d) / length;
        k = c > 0.0f && b > 0.0f ? 0.5f * (v->exponent + 1.0f) * ism__pow(c, v->exponent) * b / d2 : 0.0f;
    }
    *plain = k;
    switch (w->s.near_mode) {
    case ISM_NEAR_CLAMP: return k < w->s.clamp ? k : w->s.clamp;
    case ISM_NEAR_SPHERE:
        return a2 > 0.0f && v->exponent == 1.0f && d2 < 16.0f * a2
             ? ism__sphere_kernel(d, ism__v3_load(v->normal), px->n, v->edge) : k;
    case ISM_NEAR_PATCH:
        return a2 > 0.0f && v->exponent == 1.0f && d2 < 9.0f * a2
             ? ism__patch_kernel(f, d, px->n, v->edge, k, plain) : k;
    case ISM_NEAR_GATHER:
        share = 1.0f - ism__nearness(d2, v->reach);
        if (!(share > 0.0f)) return *plain = 0.0f;
        if (a2 > 0.0f && v->exponent == 1.0f && d2 < 9.0f * a2)
            k = ism__patch_kernel(f, d, px->n, v->edge, k, plain);
        *plain *= share;
        return k * share;
    default: return k;
    }
}

/* Writes cos cos / d^2 of consecutive VPLs, 0 where the VPL or the receiver faces away. The loop reads and
   writes plain arrays, so that compilers vectorise it. */
static void ism__kernels(const ism__shade_work *w, const ism__pixel *px, uint32_t first, uint32_t count,
                         float *out)
{
    size_t n = w->m->vpl_count;
    const float *x = w->fields + first, *y = x + n, *z = y + n;
    const float *nx = z + n, *ny = nx + n, *nz = ny + n;
    float px0 = px->p.x, py0 = px->p.y, pz0 = px->p.z;
    float ax = px->n.x, ay = px->n.y, az = px->n.z;
    uint32_t i;
    for (i = 0; i < count; i++) {
        float dx = x[i] - px0, dy = y[i] - py0, dz = z[i] - pz0, d2 = dx * dx + dy * dy + dz * dz;
        float a = ax * dx + ay * dy + az * dz, b = -(nx[i] * dx + ny[i] * dy + nz[i] * dz);
        a = a > 0.0f ? a : 0.0f;
        b = b > 0.0f ? b : 0.0f;
        out[i] = a * b / (d2 * d2 + 1e-37f);
    }
}

/* Returns the mean light, unshadowed, of a class's VPLs at a receiver, with which CLAMP_MEAN compares each.
   */
static float ism__mean_light(const ism__shade_work *w, const ism__pixel *px, uint32_t first, uint32_t end)
{
    float kernels[ISM__CHUNK], sum = 0.0f, plain;
    uint32_t at, i;
    for (at = first; at < end; at += ISM__CHUNK) {
        uint32_t count = end - at < ISM__CHUNK ? end - at : ISM__CHUNK;
        ism__kernels(w, px, at, count, kernels);
        for (i = 0; i < count; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[at + i]];
            sum += ism__kernel(w, v, &w->axes[at + i], px, kernels[i], &plain) * ism__luminance(v->flux);
        }
    }
    return end > first ? sum / (float)(end - first) : 0.0f;
}

/* Returns cos cos / d^2 of a near point's square, times the share that it takes from VPLs at this distance.
   *plain is the same without the light that the square's rule takes off. */
static float ism__near_kernel(const ism_near_point *at, const ism__pixel *px, float *plain)
{
    ism__v3 d = ism__v3_sub(ism__v3_load(at->position), px->p), normal = ism__v3_load(at->normal);
    float d2 = ism__v3_dot(d, d), h = ism__nearness(d2, at->reach), a;
    float b, k;
    if (!(h > 0.0f)) return 0.0f;
    a = ism__v3_dot(px->n, d);
    b = -ism__v3_dot(normal, d);
    if (!(a > 0.0f && b > 0.0f)) return 0.0f;
    *plain = k = a * b / (d2 * d2 + 1e-37f);
    if (d2 < 9.0f * at->edge * at->edge) {
        ism__orientation f;
        f.z = normal;
        ism__v3_basis(f.z, &f.x, &f.y);
        k = ism__patch_kernel(&f, d, px->n, at->edge, k, plain);
    }
    *plain *= h;
    return k * h;
}
