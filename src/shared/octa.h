/* unit octa, needs v3 trig: equal-area map between the unit square and the sphere, +Y at its centre */

/* Returns the unit direction of a point of the unit square. The inner diamond is the hemisphere y >= 0;
   neighbouring cells of the square are neighbours on the sphere. Clarberg, "Fast equal-area mapping of the
   (hemi)sphere using SIMD", J. Graphics Tools 13(3), 2008. */
static inline P_v3 P_octa_direction(float u, float v)
{
    float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f, x = fabsf(a), z = fabsf(b);
    float d = 1.0f - (x + z), r = 1.0f - fabsf(d);
    float s, c, f;

    P_sincos(r > 0.0f ? ((z - x) / r + 1.0f) * 0.785398163f : 0.0f, &s, &c);
    f = r * sqrtf(2.0f - r * r);
    return P_v3_make(a < 0.0f ? -f * c : f * c, d < 0.0f ? r * r - 1.0f : 1.0f - r * r,
                     b < 0.0f ? -f * s : f * s);
}

/* Writes the point u, v in [0, 1] of a unit direction n. 1 - |y| is computed from x^2 + z^2, which is exact
   near the poles. */
static inline void P_octa_square(P_v3 n, float *u, float *v)
{
    float r = sqrtf((n.x * n.x + n.z * n.z) / (1.0f + fabsf(n.y)));
    float b = P_atan2(fabsf(n.z), fabsf(n.x)) * 0.636619772f * r, a = r - b, t = a;

    if (n.y < 0.0f) {
        a = 1.0f - b;
        b = 1.0f - t;
    }
    a = a < 0.0f ? 0.0f : a > 1.0f ? 1.0f : a;
    b = b < 0.0f ? 0.0f : b > 1.0f ? 1.0f : b;
    *u = 0.5f * (n.x < 0.0f ? 1.0f - a : 1.0f + a);
    *v = 0.5f * (n.z < 0.0f ? 1.0f - b : 1.0f + b);
}
