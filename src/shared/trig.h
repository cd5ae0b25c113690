/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float P_from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t P_to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float P_copysign(float x, float s)
{
    return P_from_bits((P_to_bits(x) & 0x7fffffffu) | (P_to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float P_either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return P_from_bits((P_to_bits(a) & mask) | (P_to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void P_sincos(float x, float *sine, float *cosine)
{
    float t, r, z;
    float s, c, a, b;
    int32_t k;

    t = x > -8192.0f ? x : -8192.0f;
    t = t < 8192.0f ? t : 8192.0f;
    k = (int32_t)(t * 0.636619772f + (t < 0.0f ? -0.5f : 0.5f));
    r = ((t - (float)k * 1.5703125f) - (float)k * 4.837512969970703125e-4f) -
        (float)k * 7.5497899548918822e-8f;
    z = r * r;
    s = r + r * z * (-0.1666665494f + z * (0.008332178146f + z * -0.0001951729898f));
    c = (1.0f - 0.5f * z) + z * z * (0.04166664687f + z * (-0.001388736752f + z * 2.443845159e-5f));
    a = k & 1 ? c : s;
    b = k & 1 ? s : c;
    *sine = k & 2 ? -a : a;
    *cosine = (k + 1) & 2 ? -b : b;
}

static inline float P_sin(float x)
{
    float s, c;
    P_sincos(x, &s, &c);
    return s;
}

static inline float P_cos(float x)
{
    float s, c;
    P_sincos(x, &s, &c);
    return c;
}

/* Returns asin of 0 <= x <= 0.5, with z = x * x. The functions made of it have an absolute error of 3e-7. */
static inline float P_asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* acos(x) is P_acos_rooted(x, sqrtf(P_acos_square(x))). The square root stands apart, since C compilers do
   not vectorise it. Above a half, asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)) keeps acos exact near 0. */
static inline float P_acos_square(float x)
{
    float a = fabsf(x);
    return 0.5f * (1.0f - P_either(a < 1.0f, a, 1.0f));
}

static inline float P_acos_rooted(float x, float root)
{
    float a = fabsf(x), h = P_acos_square(x), p;
    int big = a > 0.5f;
    a = P_either(a < 1.0f, a, 1.0f);
    p = P_asin_core(P_either(big, root, a), P_either(big, h, a * a));
    p = P_either(big, 2.0f * p, 1.57079633f - p);
    return P_either(x < 0.0f, 3.14159265f - p, p);
}

static inline float P_acos(float x) { return P_acos_rooted(x, sqrtf(P_acos_square(x))); }

static inline float P_asin(float x)
{
    float a = fabsf(x), h, s, p;
    a = a < 1.0f ? a : 1.0f;
    h = 0.5f * (1.0f - a);
    s = sqrtf(h);
    s = a > 0.5f ? s : a;
    p = P_asin_core(s, a > 0.5f ? h : a * a);
    return P_copysign(a > 0.5f ? 1.57079633f - 2.0f * p : p, x);
}

/* Returns atan2 with an error of 4e-7, at most 3 ulp. All quadrants, zeros of either sign and infinities are
   as with C's atan2f; atan2(0, 0) is 0. */
static inline float P_atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float a, t, z, p;
    float hi = P_either(ax > ay, ax, ay), lo = P_either(ax > ay, ay, ax);
    int big;
    a = P_either((lo == hi) & (hi > 0.0f), 1.0f, lo / P_either(hi > 0.0f, hi, 1.0f));
    big = a > 0.414213562f;
    t = P_either(big, (a - 1.0f) / (a + 1.0f), a);
    z = t * t;
    p = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    p = P_either(big, p + 0.785398163f, p);
    p = P_either(ay > ax, 1.57079633f - p, p);
    p = P_either((int)(P_to_bits(x) >> 31), 3.14159265f - p, p);
    return P_copysign(p, y);
}

/* Returns exp(x) as 2^k (1 + r + r^2 p(r)) with |r| <= ln 2 / 2, in double, so that exp, log and pow err by
   1 ulp. */
static inline double P_exp_core(double x)
{
    double r, p, power;
    int32_t k;
    uint64_t bits;

    x = x > -110.0 ? x : -110.0;
    x = x < 90.0 ? x : 90.0;
    k = (int32_t)(x * 1.4426950408889634 + (x < 0.0 ? -0.5 : 0.5));
    r = x - (double)k * 0.69314718055994531;
    p = 0.00139460621285616904 + r * 0.000199183706518237736;
    p = 0.500000007785776445 + r * (0.166666668605852527 + r * (0.0416662700968242239 +
        r * (0.00833326438132814496 + r * p)));
    bits = (uint64_t)(k + 1023) << 52;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + (r + r * r * p));
}

/* Returns the logarithm of x > 0 from x = 2^e m with m in [sqrt(1/2), sqrt(2)), by
   log m = 2 artanh((m - 1) / (m + 1)). */
static inline double P_log_core(float x)
{
    double m = (double)x, s, z;
    uint64_t bits;
    int32_t e;

    memcpy(&bits, &m, sizeof bits);
    e = (int32_t)(bits >> 52) - 1023;
    bits = (bits & 0x000fffffffffffffu) | 0x3ff0000000000000u;
    memcpy(&m, &bits, sizeof m);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        e++;
    }
    s = (m - 1.0) / (m + 1.0);
    z = s * s;
    z *= 0.333333328227282264 + z * (0.200001675954362054 + z * (0.142686542711926518 +
         z * 0.117910756496012977));
    return (double)e * 0.69314718055994531 + 2.0 * (s + s * z);
}

/* Returns exp(x), which is infinity above 88.7228394. */
static inline float P_exp(float x)
{
    return x > 88.7228394f ? P_from_bits(0x7f800000u) : (float)P_exp_core((double)x);
}

/* Returns the natural logarithm of x, or -infinity if x is not above 0. */
static inline float P_log(float x)
{
    return x > 0.0f ? (float)P_log_core(x) : P_from_bits(0xff800000u);
}

/* Returns x^y. x below 0 counts as 0; 0^y is 0, 1 or infinity for y above, equal to or below 0. */
static inline float P_pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : P_from_bits(0x7f800000u);
    t = (double)y * P_log_core(x);
    return t > 88.722839111 ? P_from_bits(0x7f800000u) : (float)P_exp_core(t);
}
