/* unit disc, needs trig: the square mapped to the disc */

/* Writes where a point s, t of the unit square goes on the unit disc by Shirley and Chiu's concentric map,
   which keeps areas in proportion. */
static inline void P_concentric(float s, float t, float *x, float *y)
{
    float a = 2.0f * s - 1.0f, b = 2.0f * t - 1.0f, r, phi;
    float sine, cosine;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = 0.785398163f * (b / a);
    } else {
        r = b;
        phi = b == 0.0f ? 0.0f : 1.57079633f - 0.785398163f * (a / b);
    }
    P_sincos(phi, &sine, &cosine);
    *x = r * cosine;
    *y = r * sine;
}
