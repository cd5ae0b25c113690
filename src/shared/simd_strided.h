/* unit simd_strided, needs simd_lanes3: vectors of three that lie any number of bytes apart */

#define P_load_pair P_NAME_IN_SET(P_load_pair, P_SET)
#define P_load_eight P_NAME_IN_SET(P_load_eight, P_SET)
#define P_join_halves P_NAME_IN_SET(P_join_halves, P_SET)
#define P_lanes3_load_fours P_NAME_IN_SET(P_lanes3_load_fours, P_SET)

#if P_WIDTH > 4
/* Loads vectors number 0 and 4, which lie `stride` bytes apart, and the 4 bytes behind each. */
static inline P_IN_KERNEL __m256 P_load_pair(const char *from, size_t stride)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps((const float *)(const void *)from)),
                                _mm_loadu_ps((const float *)(const void *)(from + 4 * stride)), 1);
}

/* Loads x, y and z of 8 vectors, which lie `stride` bytes apart. Reads 4 bytes behind each. */
static inline P_IN_KERNEL void P_load_eight(const char *from, size_t stride, __m256 *xyz)
{
    const __m256 a = P_load_pair(from, stride), b = P_load_pair(from + stride, stride);
    const __m256 c = P_load_pair(from + 2 * stride, stride), d = P_load_pair(from + 3 * stride, stride);
    const __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
    xyz[0] = _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0));
    xyz[1] = _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2));
    xyz[2] = _mm256_shuffle_ps(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d), _MM_SHUFFLE(1, 0, 1, 0));
}
#endif

#if P_WIDTH == 16
/* Returns 16 floats of two halves. gcc 12 warns of what the insertion without a mask calls. */
static inline P_IN_KERNEL __m512 P_join_halves(__m256 low, __m256 high)
{
    return _mm512_castpd_ps(_mm512_maskz_insertf64x4(
        (__mmask8)0xff, _mm512_castps_pd(_mm512_castps256_ps512(low)), _mm256_castps_pd(high), 1));
}
#endif

/* Loads x, y, z of each lane from vectors that lie `stride` bytes apart. Reads 4 bytes behind each. */
static inline P_IN_KERNEL P_lanes3 P_lanes3_load_fours(const void *from, size_t stride)
{
    const char *at = (const char *)from;
    P_lanes3 v;
#if P_WIDTH == 16
    __m256 low[3], high[3];
    P_EACH(
        P_load_eight(at + stride * (16 * piece), stride, low);
        P_load_eight(at + stride * (16 * piece + 8), stride, high);
        v.x.v[piece] = P_join_halves(low[0], high[0]);
        v.y.v[piece] = P_join_halves(low[1], high[1]);
        v.z.v[piece] = P_join_halves(low[2], high[2]))
#elif P_WIDTH == 8
    __m256 xyz[3];
    P_EACH(
        P_load_eight(at + stride * (8 * piece), stride, xyz);
        v.x.v[piece] = xyz[0];
        v.y.v[piece] = xyz[1];
        v.z.v[piece] = xyz[2])
#else
    float xyz[3][P_LANE_COUNT];
    int l, k;
    for (l = 0; l < P_LANE_COUNT; l++)
        for (k = 0; k < 3; k++) memcpy(&xyz[k][l], at + stride * (size_t)l + 4 * k, 4);
    v = P_lanes3_load(xyz[0], xyz[1], xyz[2]);
#endif
    return v;
}
