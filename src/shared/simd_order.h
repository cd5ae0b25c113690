/* unit simd_order, needs simd_begin: sixteen lanes in another order, bytes as lanes, 8 x 8 floats
   transposed */

#define P_lanes_of_bytes P_NAME_IN_SET(P_lanes_of_bytes, P_SET)
#define P_lanes_load_halves P_NAME_IN_SET(P_lanes_load_halves, P_SET)
#define P_lanes_load_fours P_NAME_IN_SET(P_lanes_load_fours, P_SET)
#define P_lanes_swap_ones P_NAME_IN_SET(P_lanes_swap_ones, P_SET)
#define P_lanes_swap_twos P_NAME_IN_SET(P_lanes_swap_twos, P_SET)
#define P_transpose4 P_NAME_IN_SET(P_transpose4, P_SET)
#define P_transpose8 P_NAME_IN_SET(P_transpose8, P_SET)

/* Returns sixteen bytes as floats, 0..255. */
static inline P_IN_KERNEL P_lanes P_lanes_of_bytes(const uint8_t *from)
{
    P_lanes a;
#if P_WIDTH == 16
    const __mmask16 all = (__mmask16)0xffff;    /* gcc 12's conversions without a mask warn of themselves */
    const __m128i k = _mm_loadu_si128((const __m128i *)(const void *)from);
    P_EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps(all, _mm512_maskz_cvtepu8_epi32(all, k)))
#elif P_WIDTH == 8
    P_EACH(
        const __m128i k = _mm_loadl_epi64((const __m128i *)(const void *)(from + piece * P_WIDTH));
        a.v[piece] = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(k)))
#elif P_SIMD_X86
    const __m128i zero = _mm_setzero_si128(), k = _mm_loadu_si128((const __m128i *)(const void *)from);
    const __m128i low = _mm_unpacklo_epi8(k, zero), high = _mm_unpackhi_epi8(k, zero);
    a.v[0] = _mm_cvtepi32_ps(_mm_unpacklo_epi16(low, zero));
    a.v[1] = _mm_cvtepi32_ps(_mm_unpackhi_epi16(low, zero));
    a.v[2] = _mm_cvtepi32_ps(_mm_unpacklo_epi16(high, zero));
    a.v[3] = _mm_cvtepi32_ps(_mm_unpackhi_epi16(high, zero));
#elif P_SIMD_VECTORS
    P_EACH(
        const uint8_t *k = from + piece * P_WIDTH;
        const P_piece four = { (float)k[0], (float)k[1], (float)k[2], (float)k[3] };
        a.v[piece] = four)
#else
    P_EACH(a.v[piece] = (float)from[piece])
#endif
    return a;
}

/* Returns eight floats from each of two places, those of `first` in lanes 0..7. */
static inline P_IN_KERNEL P_lanes P_lanes_load_halves(const float *first, const float *second)
{
    P_lanes a;
#if P_WIDTH == 16
    const __m512 low = _mm512_castps256_ps512(_mm256_loadu_ps(first));
    P_EACH(a.v[piece] = _mm512_maskz_insertf32x8((__mmask16)0xffff, low, _mm256_loadu_ps(second), 1))
#else
    P_EACH(
        const float *from = piece * P_WIDTH < 8 ? first + piece * P_WIDTH
                                                : second + piece * P_WIDTH - 8;
        memcpy(&a.v[piece], from, sizeof a.v[piece]))
#endif
    return a;
}

/* Returns four floats, `stride` apart, each in four lanes: the first in lanes 0..3. */
static inline P_IN_KERNEL P_lanes P_lanes_load_fours(const float *from, size_t stride)
{
    P_lanes a;
#if P_WIDTH > 4
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(from[0])),
                                            _mm_set1_ps(from[stride]), 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(from[2 * stride])),
                                             _mm_set1_ps(from[3 * stride]), 1);
#endif
#if P_WIDTH == 16
    a.v[0] = _mm512_maskz_insertf32x8((__mmask16)0xffff, _mm512_castps256_ps512(low), high, 1);
#elif P_WIDTH == 8
    a.v[0] = low;
    a.v[1] = high;
#elif P_SIMD_X86
    P_EACH(a.v[piece] = _mm_set1_ps(from[piece * stride]))
#elif P_SIMD_VECTORS
    P_EACH(
        const float x = from[piece * stride];
        const P_piece four = { x, x, x, x };
        a.v[piece] = four)
#else
    P_EACH(a.v[piece] = from[(size_t)piece / 4 * stride])
#endif
    return a;
}

/* Returns lanes 1 0 3 2, 5 4 7 6, ... */
static inline P_IN_KERNEL P_lanes P_lanes_swap_ones(P_lanes a)
{
    P_lanes b;
#if P_WIDTH == 16
    P_EACH(b.v[piece] = _mm512_maskz_permute_ps((__mmask16)0xffff, a.v[piece], 0xb1))
#elif P_WIDTH == 8
    P_EACH(b.v[piece] = _mm256_permute_ps(a.v[piece], 0xb1))
#elif P_SIMD_X86
    P_EACH(b.v[piece] = _mm_shuffle_ps(a.v[piece], a.v[piece], 0xb1))
#elif P_SIMD_VECTORS
    P_EACH(
        const P_piece four = { a.v[piece][1], a.v[piece][0], a.v[piece][3], a.v[piece][2] };
        b.v[piece] = four)
#else
    P_EACH(b.v[piece] = a.v[piece ^ 1])
#endif
    return b;
}

/* Returns lanes 2 3 0 1, 6 7 4 5, ... */
static inline P_IN_KERNEL P_lanes P_lanes_swap_twos(P_lanes a)
{
    P_lanes b;
#if P_WIDTH == 16
    P_EACH(b.v[piece] = _mm512_maskz_permute_ps((__mmask16)0xffff, a.v[piece], 0x4e))
#elif P_WIDTH == 8
    P_EACH(b.v[piece] = _mm256_permute_ps(a.v[piece], 0x4e))
#elif P_SIMD_X86
    P_EACH(b.v[piece] = _mm_shuffle_ps(a.v[piece], a.v[piece], 0x4e))
#elif P_SIMD_VECTORS
    P_EACH(
        const P_piece four = { a.v[piece][2], a.v[piece][3], a.v[piece][0], a.v[piece][1] };
        b.v[piece] = four)
#else
    P_EACH(b.v[piece] = a.v[piece ^ 2])
#endif
    return b;
}

#if P_WIDTH <= 4
/* Writes the columns of 4 x 4 floats as rows. */
static inline P_IN_KERNEL void P_transpose4(const float *in, size_t in_stride, float *out,
                                            size_t out_stride)
{
#if P_SIMD_X86
    const __m128 a = _mm_loadu_ps(in), b = _mm_loadu_ps(in + in_stride);
    const __m128 c = _mm_loadu_ps(in + 2 * in_stride), d = _mm_loadu_ps(in + 3 * in_stride);
    const __m128 ab = _mm_unpacklo_ps(a, b), cd = _mm_unpacklo_ps(c, d);
    const __m128 ba = _mm_unpackhi_ps(a, b), dc = _mm_unpackhi_ps(c, d);
    _mm_storeu_ps(out, _mm_movelh_ps(ab, cd));
    _mm_storeu_ps(out + out_stride, _mm_movehl_ps(cd, ab));
    _mm_storeu_ps(out + 2 * out_stride, _mm_movelh_ps(ba, dc));
    _mm_storeu_ps(out + 3 * out_stride, _mm_movehl_ps(dc, ba));
#else
    size_t i;
    for (i = 0; i < 4; i++, out += out_stride) {
        out[0] = in[i];
        out[1] = in[in_stride + i];
        out[2] = in[2 * in_stride + i];
        out[3] = in[3 * in_stride + i];
    }
#endif
}
#endif

/* Writes the columns of 8 x 8 floats as rows. */
static inline P_IN_KERNEL void P_transpose8(const float *in, size_t in_stride, float *out,
                                            size_t out_stride)
{
    size_t i;
#if P_WIDTH > 4
    __m256 r[8], t[8];
    for (i = 0; i < 8; i++) r[i] = _mm256_loadu_ps(in + i * in_stride);
    for (i = 0; i < 4; i++) {
        t[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
        t[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
    }
    for (i = 0; i < 2; i++) {
        r[4 * i] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0x44);
        r[4 * i + 1] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0xee);
        r[4 * i + 2] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0x44);
        r[4 * i + 3] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0xee);
    }
    for (i = 0; i < 4; i++) {
        _mm256_storeu_ps(out + out_stride * i, _mm256_permute2f128_ps(r[i], r[4 + i], 0x20));
        _mm256_storeu_ps(out + out_stride * (i + 4), _mm256_permute2f128_ps(r[i], r[4 + i], 0x31));
    }
#else
    for (i = 0; i < 4; i++) {
        const size_t x = 4 * (i & 1), y = 4 * (i >> 1);
        P_transpose4(in + y * in_stride + x, in_stride, out + x * out_stride + y, out_stride);
    }
#endif
}
