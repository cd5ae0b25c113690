/* ---- cubes: texels of cube maps, and their harmonics ---- */

/* Writes a direction's components along a face's s, its t and its axis. Faces are in OpenGL's order. */
SFIELD__INLINE void sfield__to_face(uint32_t face, const float *p, float *q)
{
    float x = p[0], y = p[1], z = p[2];
    switch (face) {
    case 0: q[0] = -z, q[1] = -y, q[2] = x; break;
    case 1: q[0] = z, q[1] = -y, q[2] = -x; break;
    case 2: q[0] = x, q[1] = z, q[2] = y; break;
    case 3: q[0] = x, q[1] = -z, q[2] = -y; break;
    case 4: q[0] = x, q[1] = -y, q[2] = z; break;
    default: q[0] = -x, q[1] = -y, q[2] = -z; break;
    }
}

SFIELD__INLINE void sfield__from_face(uint32_t face, double s, double t, double d[3])
{
    switch (face) {
    case 0: d[0] = 1, d[1] = -t, d[2] = -s; break;
    case 1: d[0] = -1, d[1] = -t, d[2] = s; break;
    case 2: d[0] = s, d[1] = 1, d[2] = t; break;
    case 3: d[0] = s, d[1] = -1, d[2] = -t; break;
    case 4: d[0] = s, d[1] = -t, d[2] = 1; break;
    default: d[0] = -s, d[1] = -t, d[2] = -1; break;
    }
}

static uint32_t sfield__face_of(const float *p)
{
    float x = fabsf(p[0]), y = fabsf(p[1]), z = fabsf(p[2]);
    if (x >= y && x >= z) return p[0] > 0 ? 0u : 1u;
    if (y >= z) return p[1] > 0 ? 2u : 3u;
    return p[2] > 0 ? 4u : 5u;
}

static uint32_t sfield__spread_bits(uint32_t x)         /* 6 bits, a zero between each two */
{
    x = (x | x << 4) & 0x30fu;
    x = (x | x << 2) & 0x333u;
    return (x | x << 1) & 0x555u;
}

static uint32_t sfield__gather_bits(uint32_t x)
{
    x &= 0x555u;
    x = (x | x >> 1) & 0x333u;
    x = (x | x >> 2) & 0x30fu;
    return (x | x >> 4) & 0x3fu;
}

static uint32_t sfield__texel_number(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
{
    return face * side * side + (sfield__spread_bits(x) | sfield__spread_bits(y) << 1);
}

static void sfield__texel_place(uint32_t side, uint32_t texel, uint32_t *face, uint32_t *x, uint32_t *y)
{
    uint32_t m = texel & (side * side - 1);
    *face = texel / (side * side);
    *x = sfield__gather_bits(m);
    *y = sfield__gather_bits(m >> 1);
}

static int sfield__is_side(uint32_t side, uint32_t least)
{
    return side >= least && side <= 64 && (side & (side - 1)) == 0;
}

/* Writes the 16 Gauss-Legendre points of a texel: unit directions; weights whose sum is its solid angle. */
static void sfield__texel_points(uint32_t side, uint32_t texel, double points[16][4])
{
    static const double at[4] = { -0.86113631159405257522, -0.33998104358485626480, 0.33998104358485626480,
                                  0.86113631159405257522 };
    static const double weight[4] = { 0.34785484513745385737, 0.65214515486254614263, 0.65214515486254614263,
                                      0.34785484513745385737 };
    uint32_t face, x, y;
    uint32_t i, j;
    sfield__texel_place(side, texel, &face, &x, &y);
    for (j = 0; j < 4; j++)
        for (i = 0; i < 4; i++) {
            double *p = points[4 * j + i], s = (2.0 * x + 1 + at[i]) / side - 1,
                   t = (2.0 * y + 1 + at[j]) / side - 1;
            double length = sqrt(1 + s * s + t * t);
            sfield__from_face(face, s, t, p);
            p[0] /= length;
            p[1] /= length;
            p[2] /= length;
            p[3] = weight[i] * weight[j] / ((double)side * side * length * length * length);
        }
}

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3])
{
    double points[16][4], sum = 0, d[3], length;
    uint32_t face, x, y, i;
    if (!sfield__is_side(side, 2) || texel >= 6 * side * side || !direction) return 0;
    sfield__texel_points(side, texel, points);
    for (i = 0; i < 16; i++) sum += points[i][3];
    sfield__texel_place(side, texel, &face, &x, &y);
    sfield__from_face(face, (2.0 * x + 1) / side - 1, (2.0 * y + 1) / side - 1, d);
    length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (i = 0; i < 3; i++) direction[i] = (float)(d[i] / length);
    return (float)sum;
}

SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3])
{
    float q[3];
    uint32_t face, x, y;
    if (!sfield__is_side(side, 2) || !direction) return 0;
    face = sfield__face_of(direction);
    sfield__to_face(face, direction, q);
    if (!(q[2] > 0)) return 0;
    q[0] = (q[0] / q[2] + 1) * 0.5f * (float)side;
    q[1] = (q[1] / q[2] + 1) * 0.5f * (float)side;
    x = q[0] > 0 ? (uint32_t)q[0] : 0;
    y = q[1] > 0 ? (uint32_t)q[1] : 0;
    return sfield__texel_number(side, face, x < side ? x : side - 1, y < side ? y : side - 1);
}

/* Integrates every basis function over one texel. */
static void sfield__texel_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out)
{
    double points[16][4], y[SFIELD_MAX_COEFS], sum[SFIELD_MAX_COEFS] = { 0 };
    uint32_t i, k;
    sfield__texel_points(side, texel, points);
    for (i = 0; i < 16; i++) {
        sfield_sh_basis(bands, points[i], y);
        for (k = 0; k < bands * bands; k++) sum[k] += points[i][3] * y[k];
    }
    for (k = 0; k < bands * bands; k++) out[k] = (float)sum[k];
}

SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out)
{
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || texel >= 6 * side * side ||
        !out)
        return SFIELD_ERR_ARGUMENT;
    sfield__texel_basis(bands, side, texel, out);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels,
                                           uint32_t channels, float *coefs)
{
    double sum[3 * SFIELD_MAX_COEFS] = { 0 };
    float y[SFIELD_MAX_COEFS];
    uint32_t n = bands * bands, i, k, c;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || !texels || !coefs ||
        channels < 1 || channels > 3)
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 6 * side * side; i++) {
        sfield__texel_basis(bands, side, i, y);
        for (c = 0; c < channels; c++)
            for (k = 0; k < n; k++) sum[c * n + k] += (double)texels[i * channels + c] * (double)y[k];
    }
    for (k = 0; k < channels * n; k++) coefs[k] = (float)sum[k];
    return SFIELD_OK;
}
