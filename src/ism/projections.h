/* ---- projections: the hemisphere about +z and the unit square (paper 6.1) ---- */

/* Writes the place in the unit disc of a place (a, b) in the square -1..1, and returns its radius. After
   Shirley and Chiu, "A low distortion map between disk and square", J. Graphics Tools 2(3), 1997. */
static float ism__square_to_disc(float a, float b, float *x, float *y)
{
    float r, phi, s, c;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = 0.785398163f * (b / a);
    } else {
        r = b;
        phi = b != 0.0f ? 1.57079633f - 0.785398163f * (a / b) : 0.0f;
    }
    ism__sincos(phi, &s, &c);
    *x = r * c;
    *y = r * s;
    return fabsf(r);
}

static void ism__disc_to_square(float x, float y, float *a, float *b)
{
    float r = sqrtf(x * x + y * y);
    if (fabsf(x) > fabsf(y)) {
        *a = x < 0.0f ? -r : r;
        *b = *a * 1.27323954f * ism__atan2(y, x < 0.0f ? -x : x) * (x < 0.0f ? -1.0f : 1.0f);
    } else {
        *b = y < 0.0f ? -r : r;
        *a = *b * 1.27323954f * ism__atan2(x, y < 0.0f ? -y : y) * (y < 0.0f ? -1.0f : 1.0f);
    }
}

/* Returns 1 - x^y for x in 0..1. A small difference keeps its digits, which x^y as a float would have lost.
   */
static float ism__power_gap(float x, float y)
{
    return x > 0.0f ? (float)(1.0 - ism__exp_core((double)y * ism__log_core(x))) : 1.0f;
}

/* Returns by how much a LOBE map stretches the disc of directions with this z and this sine of the angle from
   the axis. */
static float ism__lobe_stretch(float z, float sine, float exponent)
{
    float r = ism__power_gap(z < 1.0f ? z : 1.0f, exponent + 1.0f);
    return sine > 1e-12f ? sqrtf(r > 0.0f ? r : 0.0f) / sine : 1.0f;
}

/* In the map of a LOBE equal areas have equal integrals of cos^e, which makes the radius in the disc the root
   of 1 - cos^(e + 1). With e = 1 this is the hemisphere seen from above, the map COSINE. */
ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3])
{
    float a = 2.0f * uv[0] - 1.0f, b = 2.0f * uv[1] - 1.0f, r, x;
    float y, z, s;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        r = a * a + b * b;
        s = 2.0f / (1.0f + r);
        x = a * s;
        y = b * s;
        z = (1.0f - r) / (1.0f + r);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        ism__v3 v;
        x = 0.5f * (a + b);
        y = 0.5f * (a - b);
        v = ism__v3_normalize(ism__v3_make(x, y, 1.0f - fabsf(x) - fabsf(y)));
        x = v.x;
        y = v.y;
        z = v.z;
    } else {
        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0f, sine;
        r = ism__square_to_disc(a, b, &x, &y);
        s = 1.0f - r * r;
        s = s > 0.0f ? s : 0.0f;
        z = e == 1.0f ? sqrtf(s) : ism__pow(s, 1.0f / (e + 1.0f));
        sine = e == 1.0f ? r : sqrtf(ism__power_gap(s, 2.0f / (e + 1.0f)));
        s = r > 1e-12f ? sine / r : 1.0f;
        x *= s;
        y *= s;
    }
    direction[0] = x;
    direction[1] = y;
    direction[2] = z;
}

ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2])
{
    float x = direction[0], y = direction[1], z = direction[2];
    float a, b, s;
    if (!(z > 0.0f)) return 0;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        a = x / (1.0f + z);
        b = y / (1.0f + z);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        s = 1.0f / (fabsf(x) + fabsf(y) + z);
        a = (x + y) * s;
        b = (x - y) * s;
    } else {
        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0f;
        if (e != 1.0f) {
            s = ism__lobe_stretch(z, sqrtf(x * x + y * y), e);
            x *= s;
            y *= s;
        }
        ism__disc_to_square(x, y, &a, &b);
    }
    a = 0.5f * a + 0.5f;
    b = 0.5f * b + 0.5f;
    uv[0] = a < 0.0f ? 0.0f : a < 1.0f ? a : 1.0f;
    uv[1] = b < 0.0f ? 0.0f : b < 1.0f ? b : 1.0f;
    return 1;
}

static ism__v3 ism__to_local(const ism__orientation *f, ism__v3 v)
{
    return ism__v3_make(ism__v3_dot(f->x, v), ism__v3_dot(f->y, v), ism__v3_dot(f->z, v));
}

static ism__v3 ism__to_world(const ism__orientation *f, ism__v3 v)
{
    return ism__v3_madd(ism__v3_madd(ism__v3_scale(f->x, v.x), f->y, v.y), f->z, v.z);
}

static ism_projection ism__projection_of(const ism_maps *m, const ism_vpl *v)
{
    if (m->desc.projection == ISM_PROJECTION_LOBE && v->exponent == 1.0f) return ISM_PROJECTION_COSINE;
    return m->desc.projection;
}

/* Returns the axes of a VPL's map. z is the lobe's axis in maps of LOBE, the normal in others, and the way
   that light travels in maps of directions. */
static ism__orientation ism__vpl_axes(const ism_maps *m, const ism_vpl *v)
{
    ism__orientation f;
    f.z = ism__v3_load(ism__projection_of(m, v) == ISM_PROJECTION_LOBE && !v->directional ? v->axis
                                                                                          : v->normal);
    ism__v3_basis(f.z, &f.x, &f.y);
    return f;
}

/* Returns the texel in which u, 0..1, lies; the nearest texel for u beyond, and the first for what is not a
   number. */
static uint32_t ism__texel_of(float u, uint32_t size)
{
    float x = u * (float)size;
    if (!(x > 0.0f)) return 0;
    return x < (float)size ? (uint32_t)x : size - 1u;
}
