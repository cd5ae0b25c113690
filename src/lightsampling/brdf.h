/* ---- brdf: a material at a point, evaluated and sampled ---- */

typedef struct lsamp__cosine_lobe { /* scale max(0, axis . wi)^exponent */
    lsamp__v3 axis, scale;
    float     exponent;
} lsamp__cosine_lobe;

typedef struct lsamp__surface {  /* a material at one point; all directions are along the axes t, b, n */
    lsamp__v3 t, b, n;           /* tangent, bitangent and normal, orthonormal */
    lsamp__v3 to_eye;                /* the direction to the eye */
    lsamp__v3 diffuse;           /* the albedo of the diffuse part */
    lsamp__v3 f0;                /* METAL_ROUGH: the reflectance along the normal */
    float     alpha;             /* METAL_ROUGH: of GGX; 0: the specular part consists of cosine lobes */
    uint32_t  lobe_count;
    lsamp__cosine_lobe lobes[LSAMP_MAX_LOBES];
    float     lobe_share[LSAMP_MAX_LOBES]; /* the probability that roulette takes a lobe; the sum is 1 */
    float     diffuse_share;     /* the probability that it takes the diffuse part: k_d of the paper */
    float     peak;              /* roughly the largest density of the BRDF's samples, 1/sr */
    int       black;             /* nothing is reflected */
} lsamp__surface;

typedef struct lsamp__response { /* f and density for one wi, of the diffuse and the specular part apart */
    lsamp__v3 diffuse, specular;
    float     diffuse_pdf, specular_pdf;
} lsamp__response;

static lsamp__v3 lsamp__to_axes(const lsamp__surface *s, lsamp__v3 w)
{
    return lsamp__v3_make(lsamp__v3_dot(w, s->t), lsamp__v3_dot(w, s->b), lsamp__v3_dot(w, s->n));
}

static float lsamp__pow5(float x) { return x * x * (x * x) * x; }

static lsamp__v3 lsamp__schlick(lsamp__v3 f0, float cosine)
{
    float f = lsamp__pow5(1.0f - cosine);
    return lsamp__v3_madd(lsamp__v3_scale(f0, 1.0f - f), lsamp__v3_make(1.0f, 1.0f, 1.0f), f);
}

/* A field of a material that is out of range: its name, its value, and where the value must lie. */
typedef struct lsamp__fault { const char *field, *wanted; float value; } lsamp__fault;

/* Says whether each of count values is a number within low..high; if not, sets the fault. */
static int lsamp__values_in(lsamp__fault *f, const char *field, const float *values, int count, float low,
                       float high, const char *wanted)
{
    int k;
    for (k = 0; k < count; k++) {
        if (lsamp__in(values[k], low, high)) continue;
        f->field = field;
        f->value = values[k];
        f->wanted = wanted;
        return 0;
    }
    return 1;
}

static int lsamp__lobes_valid(const lsamp_material *m, lsamp__fault *f)
{
    uint32_t i;
    float count = (float)m->lobe_count;

    if (!lsamp__values_in(f, "has the lobe_count", &count, 1, 0.0f, (float)LSAMP_MAX_LOBES, "0..8")) return 0;
    if (!lsamp__values_in(f, "has no lobes, but the lobe_count", &count, 1, 0.0f, m->lobes ? count : 0.0f,
                     "0 then"))
        return 0;
    for (i = 0; i < m->lobe_count; i++)
        if (!lsamp__values_in(f, "has a lobe with the axis", m->lobes[i].axis, 3, -10.0f, 10.0f, "-10..10") ||
            !lsamp__values_in(f, "has a lobe with the scale", m->lobes[i].scale, 3, 0.0f, 1e9f, "0..1e9") ||
            !lsamp__values_in(f, "has a lobe with the exponent", &m->lobes[i].exponent, 1, 0.0f, 1e5f,
                         "0..100000"))
            return 0;
    return 1;
}

static int lsamp__material_valid(const lsamp_material *m, lsamp__fault *f)
{
    float kind = (float)m->kind;

    if (!lsamp__values_in(f, "has the kind", &kind, 1, 0.0f, (float)LSAMP_MATERIAL_COUNT - 1.0f,
                     "a LSAMP_MATERIAL_...") ||
        !lsamp__values_in(f, "has the diffuse", m->diffuse, 3, 0.0f, 1.0f, "0..1"))
        return 0;
    if (m->kind == LSAMP_MATERIAL_PHONG)
        return lsamp__values_in(f, "has the specular", m->specular, 3, 0.0f, 1.0f, "0..1") &&
               lsamp__values_in(f, "has the exponent", &m->exponent, 1, 0.0f, 1e5f, "0..100000");
    if (m->kind == LSAMP_MATERIAL_METAL_ROUGH)
        return lsamp__values_in(f, "has the metallic", &m->metallic, 1, 0.0f, 1.0f, "0..1") &&
               lsamp__values_in(f, "has the roughness", &m->roughness, 1, 0.0f, 1.0f, "0..1");
    return m->kind != LSAMP_MATERIAL_LAFORTUNE || lsamp__lobes_valid(m, f);
}

/* Adds a lobe about C to_eye, and returns roughly its albedo, which only steers the roulette. */
static float lsamp__add_lobe(lsamp__surface *s, lsamp__v3 c, float exponent, lsamp__v3 scale)
{
    lsamp__cosine_lobe *lobe = &s->lobes[s->lobe_count];
    lsamp__v3 a = lsamp__v3_mul(c, s->to_eye);
    float length = lsamp__v3_length(a), albedo;

    if (!(length > 0.0f)) return 0.0f;
    lobe->axis = lsamp__v3_scale(a, 1.0f / length);
    lobe->exponent = exponent;
    lobe->scale = lsamp__v3_scale(scale, exponent > 0.0f ? lsamp__pow(length, exponent) : 1.0f);
    albedo = lsamp__mean3(lobe->scale) * 2.0f * LSAMP__PI / (exponent + 2.0f);
    albedo *= lobe->axis.z > 0.1f ? lobe->axis.z : 0.1f;
    if (!(albedo > 0.0f) || !lsamp__v3_finite(lobe->scale)) return 0.0f;
    s->lobe_share[s->lobe_count++] = albedo;
    return albedo;
}

static float lsamp__specular_init(lsamp__surface *s, const lsamp_material *m)
{
    lsamp__v3 base = lsamp__v3_load(m->diffuse);
    float sum = 0.0f;
    uint32_t i;

    if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        s->alpha = m->roughness * m->roughness > 0.002f ? m->roughness * m->roughness : 0.002f;
        s->f0 = lsamp__v3_make(0.04f, 0.04f, 0.04f);
        s->f0 = lsamp__v3_madd(lsamp__v3_scale(s->f0, 1.0f - m->metallic), base, m->metallic);
        s->diffuse = lsamp__v3_scale(base, 1.0f - m->metallic);
        s->lobe_count = 1;
        s->lobe_share[0] = sum = lsamp__mean3(lsamp__schlick(s->f0, s->to_eye.z));
    } else if (m->kind == LSAMP_MATERIAL_PHONG) {
        float norm = (m->exponent + 2.0f) / (2.0f * LSAMP__PI);
        sum = lsamp__add_lobe(s, lsamp__v3_make(-1.0f, -1.0f, 1.0f), m->exponent,
                              lsamp__v3_scale(lsamp__v3_load(m->specular), norm));
    } else if (m->kind == LSAMP_MATERIAL_LAFORTUNE) {
        for (i = 0; i < m->lobe_count; i++)
            sum += lsamp__add_lobe(s, lsamp__v3_load(m->lobes[i].axis), m->lobes[i].exponent,
                                   lsamp__v3_load(m->lobes[i].scale));
    }
    return sum;
}

static void lsamp__surface_init(lsamp__surface *s, const lsamp_material *m, lsamp__v3 n, const float *tangent,
                                lsamp__v3 to_eye)
{
    lsamp__v3 t = tangent ? lsamp__v3_load(tangent) : lsamp__v3_make(0.0f, 0.0f, 0.0f);
    float specular, diffuse;
    uint32_t i;

    s->n = lsamp__v3_normalize(n);
    t = lsamp__v3_madd(t, s->n, -lsamp__v3_dot(t, s->n));
    if (lsamp__v3_dot(t, t) > 1e-6f) {
        s->t = lsamp__v3_normalize(t);
        s->b = lsamp__v3_cross(s->n, s->t);
    } else {
        lsamp__v3_basis(s->n, &s->t, &s->b);
    }
    s->to_eye = lsamp__to_axes(s, lsamp__v3_normalize(to_eye));
    if (s->to_eye.z < 1e-3f) {       /* the eye may be below the horizon of a normal that was interpolated */
        s->to_eye.z = 1e-3f;
        s->to_eye = lsamp__v3_normalize(s->to_eye);
    }
    if (s->to_eye.z > 1.0f) s->to_eye.z = 1.0f;
    s->diffuse = lsamp__v3_load(m->diffuse);
    s->alpha = 0.0f;
    s->lobe_count = 0;
    specular = lsamp__specular_init(s, m);
    for (i = 0; i < s->lobe_count; i++) s->lobe_share[i] /= specular;
    diffuse = lsamp__mean3(s->diffuse);
    s->black = !(diffuse + specular > 0.0f);
    s->diffuse_share = s->black ? 1.0f : diffuse / (diffuse + specular);
    s->peak = s->diffuse_share * (1.0f / LSAMP__PI);
    for (i = 0; i < s->lobe_count; i++) {
        float lobe = s->alpha > 0.0f ? 0.25f / (LSAMP__PI * s->alpha * s->alpha)
                                     : (s->lobes[i].exponent + 1.0f) / (2.0f * LSAMP__PI);
        s->peak += (1.0f - s->diffuse_share) * s->lobe_share[i] * lobe;
    }
}

/* Evaluates GGX with Smith's height-correlated shadowing (Heitz, JCGT 3(2), 2014). 1 - nh^2 is computed as
   hx^2 + hy^2, which keeps the digits of narrow peaks. The density is that of visible normals. */
static void lsamp__ggx_response(const lsamp__surface *s, lsamp__v3 wi, lsamp__response *r)
{
    lsamp__v3 h = lsamp__v3_normalize(lsamp__v3_add(s->to_eye, wi)), f;
    float a2 = s->alpha * s->alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (LSAMP__PI * q * q);
    float go = sqrtf(a2 + (1.0f - a2) * s->to_eye.z * s->to_eye.z);
    float gi = sqrtf(a2 + (1.0f - a2) * wi.z * wi.z);
    float vh = lsamp__v3_dot(s->to_eye, h);

    vh = vh > 0.0f ? vh < 1.0f ? vh : 1.0f : 0.0f;
    f = lsamp__schlick(s->f0, vh);
    r->specular = lsamp__v3_scale(f, 0.5f * d / (wi.z * go + s->to_eye.z * gi));
    r->diffuse = lsamp__v3_mul(r->diffuse, lsamp__v3_make(1.0f - f.x, 1.0f - f.y, 1.0f - f.z));
    r->specular_pdf = 0.5f * d / (s->to_eye.z + go);
}

static lsamp__response lsamp__brdf_response(const lsamp__surface *s, lsamp__v3 wi)
{
    lsamp__response r;
    uint32_t i;

    memset(&r, 0, sizeof r);
    if (!(wi.z > 0.0f)) return r;
    r.diffuse = lsamp__v3_scale(s->diffuse, 1.0f / LSAMP__PI);
    r.diffuse_pdf = wi.z * (1.0f / LSAMP__PI);
    if (s->lobe_count && s->alpha > 0.0f) {
        lsamp__ggx_response(s, wi, &r);
        return r;
    }
    for (i = 0; i < s->lobe_count; i++) {
        const lsamp__cosine_lobe *lobe = &s->lobes[i];
        float c = lsamp__v3_dot(lobe->axis, wi);
        if (!(c > 0.0f)) continue;
        c = lsamp__pow(c, lobe->exponent);
        r.specular = lsamp__v3_madd(r.specular, lobe->scale, c);
        r.specular_pdf += s->lobe_share[i] * c * (lobe->exponent + 1.0f) / (2.0f * LSAMP__PI);
    }
    return r;
}

static float lsamp__brdf_pdf(const lsamp__surface *s, const lsamp__response *r)
{
    return s->diffuse_share * r->diffuse_pdf + (1.0f - s->diffuse_share) * r->specular_pdf;
}

/* Draws a visible normal by spherical caps: Dupuy and Benyoub, "Sampling visible GGX normals with spherical
   caps", 2023. */
static lsamp__v3 lsamp__ggx_draw(const lsamp__surface *s, float u, float v)
{
    float a = s->alpha, z, r;
    float sn, cs, d;
    lsamp__v3 o = lsamp__v3_normalize(lsamp__v3_make(s->to_eye.x * a, s->to_eye.y * a, s->to_eye.z)), h;

    z = (1.0f - u) * (1.0f + o.z) - o.z;
    r = lsamp__safe_sqrt(1.0f - z * z);
    lsamp__sincos(2.0f * LSAMP__PI * v, &sn, &cs);
    h = lsamp__v3_add(lsamp__v3_make(r * cs, r * sn, z), o);
    h = lsamp__v3_normalize(lsamp__v3_make(h.x * a, h.y * a, h.z));
    d = 2.0f * lsamp__v3_dot(s->to_eye, h);
    return lsamp__v3_normalize(lsamp__v3_sub(lsamp__v3_scale(h, d), s->to_eye));
}

static lsamp__v3 lsamp__lobe_draw(const lsamp__cosine_lobe *lobe, float u, float v)
{
    lsamp__v3 t, b;
    float c = lsamp__pow(1.0f - u, 1.0f / (lobe->exponent + 1.0f)), r = lsamp__safe_sqrt(1.0f - c * c), sn,
          cs;
    lsamp__v3_basis(lobe->axis, &t, &b);
    lsamp__sincos(2.0f * LSAMP__PI * v, &sn, &cs);
    return lsamp__from_axes(t, b, lobe->axis, lsamp__v3_make(r * cs, r * sn, c));
}

/* Draws wi along the surface's axes. u picks the lobe and is then stretched over [0, 1) again, by which it
   stays stratified. */
static lsamp__v3 lsamp__brdf_draw(const lsamp__surface *s, float diffuse_share, float u, float v)
{
    uint32_t i = 0;
    if (u < diffuse_share || s->lobe_count == 0) {
        float x, y;
        lsamp__concentric(diffuse_share > 0.0f ? lsamp__clamp_unit(u / diffuse_share) : u, v, &x, &y);
        return lsamp__v3_make(x, y, lsamp__safe_sqrt(1.0f - x * x - y * y));
    }
    u = (u - diffuse_share) / (1.0f - diffuse_share);
    if (s->alpha > 0.0f) return lsamp__ggx_draw(s, lsamp__clamp_unit(u), v);
    for (; i + 1u < s->lobe_count && u >= s->lobe_share[i]; i++) u -= s->lobe_share[i];
    return lsamp__lobe_draw(&s->lobes[i], lsamp__clamp_unit(u / s->lobe_share[i]), v);
}

static lsamp_result lsamp__brdf_prepare(lsamp__surface *s, const lsamp_material *m, const float *normal,
                                        const float *tangent, const float *to_eye)
{
    lsamp__fault fault;          /* stays here, since these calls have no log */

    if (!m || !normal || !to_eye) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__is_unit(normal) || !lsamp__is_unit(to_eye) || (tangent && !lsamp__is_unit(tangent)) ||
        !lsamp__material_valid(m, &fault))
        return LSAMP_ERR_INPUT;
    lsamp__surface_init(s, m, lsamp__v3_load(normal), tangent, lsamp__v3_load(to_eye));
    return LSAMP_OK;
}

/* Writes f and the density for wi, which is along the surface's axes. */
static void lsamp__brdf_result(const lsamp__surface *s, lsamp__v3 wi, float *f, float *pdf)
{
    lsamp__response r = lsamp__brdf_response(s, wi);
    lsamp__v3_store(f, lsamp__v3_add(r.diffuse, r.specular));
    *pdf = s->black ? 0.0f : lsamp__brdf_pdf(s, &r);
}

LSAMP_DEF lsamp_result lsamp_brdf_eval(const lsamp_material *material, const float normal[3],
                                       const float tangent[3], const float to_eye[3],
                                       const float direction[3],
                                       float f[3], float *pdf)
{
    lsamp__surface s;
    lsamp_result result = lsamp__brdf_prepare(&s, material, normal, tangent, to_eye);

    if (result != LSAMP_OK) return result;
    if (!direction || !f || !pdf) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__is_unit(direction)) return LSAMP_ERR_INPUT;
    lsamp__brdf_result(&s, lsamp__to_axes(&s, lsamp__v3_normalize(lsamp__v3_load(direction))), f, pdf);
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_brdf_sample(const lsamp_material *material, const float normal[3],
                                         const float tangent[3], const float to_eye[3], const float u[2],
                                         float direction[3], float f[3], float *pdf)
{
    lsamp__surface s;
    lsamp__v3 w;
    lsamp_result result = lsamp__brdf_prepare(&s, material, normal, tangent, to_eye);

    if (result != LSAMP_OK) return result;
    if (!u || !direction || !f || !pdf) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__in(u[0], 0.0f, LSAMP__BELOW_1) || !lsamp__in(u[1], 0.0f, LSAMP__BELOW_1))
        return LSAMP_ERR_INPUT;
    w = lsamp__brdf_draw(&s, s.diffuse_share, u[0], u[1]);
    lsamp__brdf_result(&s, w, f, pdf);
    lsamp__v3_store(direction, *pdf > 0.0f ? lsamp__from_axes(s.t, s.b, s.n, w) : s.n);
    return LSAMP_OK;
}
