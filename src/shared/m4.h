/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline P_v3 P_m4_point(const float *m, P_v3 p)
{
    return P_v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

static inline P_v3 P_m4_direction(const float *m, P_v3 d)
{
    return P_v3_make(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                     m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *P_m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int P_m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!P_finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Writes the inverse of m, which may be out itself, and returns 1. Returns 0, with out untouched, if m is
   singular to float precision; the test compares the determinant with the product of the column lengths and
   is therefore free of scale. The arithmetic is double, since the inverse of a badly scaled matrix is used
   on points. */
static inline int P_m4_affine_inverse(float *out, const float *m)
{
    double n[3][3], r[12], det, size;
    double tx = (double)m[12], ty = (double)m[13], tz = (double)m[14];
    int i, j;

    for (i = 0; i < 9; i++) n[i % 3][i / 3] = (double)m[4 * (i / 3) + i % 3];
    for (i = 0; i < 3; i++)         /* cofactors: rows and columns in turn give them their signs */
        for (j = 0; j < 3; j++)
            r[3 * j + i] = n[(j + 1) % 3][(i + 1) % 3] * n[(j + 2) % 3][(i + 2) % 3] -
                           n[(j + 1) % 3][(i + 2) % 3] * n[(j + 2) % 3][(i + 1) % 3];
    det = n[0][0] * r[0] + n[0][1] * r[1] + n[0][2] * r[2];
    size = sqrt((n[0][0] * n[0][0] + n[1][0] * n[1][0] + n[2][0] * n[2][0]) *
                (n[0][1] * n[0][1] + n[1][1] * n[1][1] + n[2][1] * n[2][1])) *
           sqrt(n[0][2] * n[0][2] + n[1][2] * n[1][2] + n[2][2] * n[2][2]);
    if (!(det > 1e-7 * size || det < -1e-7 * size)) return 0;
    for (i = 0; i < 9; i++) r[i] /= det;
    for (i = 0; i < 3; i++) r[9 + i] = -(r[i] * tx + r[3 + i] * ty + r[6 + i] * tz);
    for (i = 0; i < 12; i++)
        if (!P_finite((float)r[i])) return 0;
    for (i = 0; i < 4; i++) {
        out[4 * i] = (float)r[3 * i];
        out[4 * i + 1] = (float)r[3 * i + 1];
        out[4 * i + 2] = (float)r[3 * i + 2];
        out[4 * i + 3] = i == 3 ? 1.0f : 0.0f;
    }
    return 1;
}

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int P_m4_is_rigid_uniform(const float *m, float *scale)
{
    P_v3 x = P_v3_load(m), y = P_v3_load(m + 4), z = P_v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

    if (!P_m4_is_affine(m)) return 0;
    lx = P_v3_length(x);
    ly = P_v3_length(y);
    lz = P_v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !P_finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = P_v3_scale(x, 1.0f / lx);
    y = P_v3_scale(y, 1.0f / ly);
    z = P_v3_scale(z, 1.0f / lz);
    if (fabsf(P_v3_dot(x, y)) > 1e-4f || fabsf(P_v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(P_v3_dot(y, z)) > 1e-4f ||
        P_v3_dot(P_v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}
