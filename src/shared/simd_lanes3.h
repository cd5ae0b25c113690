/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct P_lanes3 { P_lanes x, y, z; } P_lanes3;

static inline P_IN_KERNEL P_lanes3 P_lanes3_load(const float *x, const float *y, const float *z)
{
    P_lanes3 a;
    a.x = P_lanes_load(x);
    a.y = P_lanes_load(y);
    a.z = P_lanes_load(z);
    return a;
}

/* Loads x, y, z of the first lane, then those of the next, and so on. */
static inline P_IN_KERNEL P_lanes3 P_lanes3_load_packed(const float *xyz)
{
    P_lanes3 v;
#if P_WIDTH == 16
    static const int32_t from[16] = { 0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45 };
    static const int32_t next[16] = { 1, 4, 7, 10, 13, 16, 19, 22, 25, 28, 31, 34, 37, 40, 43, 46 };
    static const int32_t last[16] = { 2, 5, 8, 11, 14, 17, 20, 23, 26, 29, 32, 35, 38, 41, 44, 47 };
    P_EACH(
        const float *at = xyz + 3 * P_WIDTH * piece;
        const __m512 a = _mm512_loadu_ps(at);
        const __m512 b = _mm512_loadu_ps(at + 16);
        const __m512 c = _mm512_loadu_ps(at + 32);
        const __m512i i = _mm512_loadu_si512(from);
        const __m512i j = _mm512_loadu_si512(next);
        const __m512i k = _mm512_loadu_si512(last);
        v.x.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, i, b), (__mmask16)0xf800, i, c);
        v.y.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, j, b), (__mmask16)0xf800, j, c);
        v.z.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, k, b), (__mmask16)0xfc00, k, c))
#elif P_WIDTH == 8                          /* in each half: a = x y z x, b = y z x y, c = z x y z */
    P_EACH(
        const float *at = xyz + 3 * P_WIDTH * piece;
        const __m256 a = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at)), _mm_loadu_ps(at + 12), 1);
        const __m256 b = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at + 4)), _mm_loadu_ps(at + 16), 1);
        const __m256 c = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at + 8)), _mm_loadu_ps(at + 20), 1);
        const __m256 ab = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
        const __m256 bc = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
        v.x.v[piece] = _mm256_shuffle_ps(a, bc, _MM_SHUFFLE(2, 0, 3, 0));
        v.y.v[piece] = _mm256_shuffle_ps(ab, bc, _MM_SHUFFLE(3, 1, 2, 0));
        v.z.v[piece] = _mm256_shuffle_ps(ab, c, _MM_SHUFFLE(3, 0, 3, 1)))
#else
    float x[P_LANE_COUNT], y[P_LANE_COUNT], z[P_LANE_COUNT];
    int l;
    for (l = 0; l < P_LANE_COUNT; l++) {
        x[l] = xyz[3 * l];
        y[l] = xyz[3 * l + 1];
        z[l] = xyz[3 * l + 2];
    }
    v = P_lanes3_load(x, y, z);
#endif
    return v;
}

static inline P_IN_KERNEL P_lanes3 P_lanes3_all(float x, float y, float z)
{
    P_lanes3 a;
    a.x = P_lanes_all(x);
    a.y = P_lanes_all(y);
    a.z = P_lanes_all(z);
    return a;
}

static inline P_IN_KERNEL P_lanes3 P_lanes3_sub(P_lanes3 a, P_lanes3 b)
{
    a.x = P_lanes_sub(a.x, b.x);
    a.y = P_lanes_sub(a.y, b.y);
    a.z = P_lanes_sub(a.z, b.z);
    return a;
}

static inline P_IN_KERNEL P_lanes3 P_lanes3_scale(P_lanes3 a, P_lanes s)
{
    a.x = P_lanes_mul(a.x, s);
    a.y = P_lanes_mul(a.y, s);
    a.z = P_lanes_mul(a.z, s);
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes3_dot(P_lanes3 a, P_lanes3 b)
{
    return P_lanes_add(P_lanes_add(P_lanes_mul(a.x, b.x), P_lanes_mul(a.y, b.y)),
                       P_lanes_mul(a.z, b.z));
}

/* Stores x, y, z of the first lane, then those of the next, and so on. */
static inline P_IN_KERNEL void P_lanes3_store_packed(float *xyz, P_lanes3 a)
{
#if P_WIDTH == 16
    static const int32_t from[16] = { 0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5 };
    static const int32_t third[16] = { 0, 1, 16, 3, 4, 17, 6, 7, 18, 9, 10, 19, 12, 13, 20, 15 };
    static const int32_t from1[16] = { 21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26 };
    static const int32_t third1[16] = { 0, 21, 2, 3, 22, 5, 6, 23, 8, 9, 24, 11, 12, 25, 14, 15 };
    static const int32_t from2[16] = { 0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0 };
    static const int32_t third2[16] = { 26, 1, 2, 27, 4, 5, 28, 7, 8, 29, 10, 11, 30, 13, 14, 31 };
    P_EACH(
        const __m512 p = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from), a.y.v[piece]);
        const __m512 q = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from1), a.y.v[piece]);
        const __m512 r = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from2), a.y.v[piece]);
        float *to = xyz + 3 * P_WIDTH * piece;
        _mm512_storeu_ps(to, _mm512_permutex2var_ps(p, _mm512_loadu_si512(third), a.z.v[piece]));
        _mm512_storeu_ps(to + 16, _mm512_permutex2var_ps(q, _mm512_loadu_si512(third1), a.z.v[piece]));
        _mm512_storeu_ps(to + 32, _mm512_permutex2var_ps(r, _mm512_loadu_si512(third2), a.z.v[piece])))
#else
    float x[P_LANE_COUNT], y[P_LANE_COUNT], z[P_LANE_COUNT];
    int l;
    P_lanes_store(x, a.x);
    P_lanes_store(y, a.y);
    P_lanes_store(z, a.z);
    for (l = 0; l < P_LANE_COUNT; l++) {
        xyz[3 * l] = x[l];
        xyz[3 * l + 1] = y[l];
        xyz[3 * l + 2] = z[l];
    }
#endif
}
