/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct P_v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} P_v3;

static inline P_v3 P_v3_make(float x, float y, float z)
{
    P_v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline P_v3 P_v3_load(const float *p) { return P_v3_make(p[0], p[1], p[2]); }
static inline void P_v3_store(float *p, P_v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline P_v3 P_v3_add(P_v3 a, P_v3 b)
{
    return P_v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline P_v3 P_v3_sub(P_v3 a, P_v3 b)
{
    return P_v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline P_v3 P_v3_mul(P_v3 a, P_v3 b)
{
    return P_v3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline P_v3 P_v3_scale(P_v3 a, float s)
{
    return P_v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
static inline P_v3 P_v3_madd(P_v3 a, P_v3 b, float s)
{
    return P_v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float P_v3_dot(P_v3 a, P_v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float P_v3_length(P_v3 a)
{
    return sqrtf(P_v3_dot(a, a));
}

static inline P_v3 P_v3_cross(P_v3 a, P_v3 b)
{
    return P_v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline P_v3 P_v3_min(P_v3 a, P_v3 b)
{
    return P_v3_make(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

static inline P_v3 P_v3_max(P_v3 a, P_v3 b)
{
    return P_v3_make(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline P_v3 P_v3_normalize(P_v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return P_v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = P_v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = P_v3_make(a.x / m, a.y / m, a.z / m);
    m = P_v3_length(a);
    return P_v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int P_finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int P_in(float x, float low, float high) { return P_finite(x) && x >= low && x <= high; }

static inline int P_v3_finite(P_v3 a)
{
    return P_finite(a.x) && P_finite(a.y) && P_finite(a.z);
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void P_v3_basis(P_v3 n, P_v3 *b1, P_v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = P_v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = P_v3_make(b, s + n.y * n.y * a, -n.y);
}
