/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if P_SIMD_X86 || P_WIDTH > 4

#if P_WIDTH == 16
typedef struct P_lanes { __m512 v[P_LANE_COUNT / 16]; } P_lanes;
typedef struct P_lane_ints { __m512i v[P_LANE_COUNT / 16]; } P_lane_ints;
typedef struct P_lane_mask { __mmask16 v[P_LANE_COUNT / 16]; } P_lane_mask;
#elif P_WIDTH == 8
typedef struct P_lanes { __m256 v[P_LANE_COUNT / 8]; } P_lanes;
typedef struct P_lane_ints { __m256i v[P_LANE_COUNT / 8]; } P_lane_ints;
typedef struct P_lane_mask { __m256 v[P_LANE_COUNT / 8]; } P_lane_mask;
#else
typedef struct P_lanes { __m128 v[P_LANE_COUNT / 4]; } P_lanes;
typedef struct P_lane_ints { __m128i v[P_LANE_COUNT / 4]; } P_lane_ints;
typedef struct P_lane_mask { __m128 v[P_LANE_COUNT / 4]; } P_lane_mask;
#endif

static inline P_IN_KERNEL P_lanes P_lanes_load(const float *from)
{
    P_lanes a;
    P_EACH(a.v[piece] = P_INTEL(loadu_ps)(from + piece * P_WIDTH))
    return a;
}

static inline P_IN_KERNEL void P_lanes_store(float *to, P_lanes a)
{
    P_EACH(P_INTEL(storeu_ps)(to + piece * P_WIDTH, a.v[piece]))
}

static inline P_IN_KERNEL P_lanes P_lanes_all(float x)
{
    P_lanes a;
    P_EACH(a.v[piece] = P_INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline P_IN_KERNEL P_lane_mask P_lanes_greater(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif P_WIDTH == 8
    P_EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    P_EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_lanes_at_least(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif P_WIDTH == 8
    P_EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    P_EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_lanes_differ(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#elif P_WIDTH == 8
    P_EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#else
    P_EACH(m.v[piece] = _mm_cmpneq_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline P_IN_KERNEL P_lanes P_lanes_select(P_lane_mask m, P_lanes a,
                                                 P_lanes b)
{
#if P_WIDTH == 16
    P_EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif P_WIDTH == 8
    P_EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    P_EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_add(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = P_INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_sub(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = P_INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_mul(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = P_INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_div(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = P_INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a b + c. */
static inline P_IN_KERNEL P_lanes P_lanes_muladd(P_lanes a, P_lanes b, P_lanes c)
{
#if P_WIDTH > 4
    P_EACH(a.v[piece] = P_INTEL(fmadd_ps)(a.v[piece], b.v[piece], c.v[piece]))
#else
    P_EACH(a.v[piece] = _mm_add_ps(_mm_mul_ps(a.v[piece], b.v[piece]), c.v[piece]))
#endif
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline P_IN_KERNEL P_lanes P_lanes_max(P_lanes a, P_lanes b)
{
#if P_WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    P_EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    P_EACH(a.v[piece] = P_INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline P_IN_KERNEL P_lanes P_lanes_min(P_lanes a, P_lanes b)
{
#if P_WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    P_EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    P_EACH(a.v[piece] = P_INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_sqrt(P_lanes a)
{
#if P_WIDTH == 16
    P_EACH(a.v[piece] = _mm512_maskz_sqrt_ps((__mmask16)0xffff, a.v[piece]))
#else
    P_EACH(a.v[piece] = P_INTEL(sqrt_ps)(a.v[piece]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_abs(P_lanes a)
{
    P_EACH(a.v[piece] = P_INTEL(andnot_ps)(P_INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_negate(P_lanes a)
{
    P_EACH(a.v[piece] = P_INTEL(xor_ps)(P_INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline P_IN_KERNEL P_lanes P_lanes_keep(P_lane_mask m, P_lanes a)
{
#if P_WIDTH == 16
    P_EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    P_EACH(a.v[piece] = P_INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline P_IN_KERNEL P_lane_ints P_lanes_truncate(P_lanes a)
{
    P_lane_ints k;
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_maskz_cvttps_epi32((__mmask16)0xffff, a.v[piece]))
#else
    P_EACH(k.v[piece] = P_INTEL(cvttps_epi32)(a.v[piece]))
#endif
    return k;
}

static inline P_IN_KERNEL P_lanes P_lanes_of_ints(P_lane_ints k)
{
    P_lanes a;
#if P_WIDTH == 16
    P_EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps((__mmask16)0xffff, k.v[piece]))
#else
    P_EACH(a.v[piece] = P_INTEL(cvtepi32_ps)(k.v[piece]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_of_shorts(const int16_t *from)
{
    P_lanes a;
#if P_WIDTH == 16
    const __mmask16 all = (__mmask16)0xffff;    /* gcc 12's conversions without a mask warn of themselves */
    P_EACH(
        __m256i k = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * P_WIDTH));
        a.v[piece] = _mm512_maskz_cvtepi32_ps(all, _mm512_maskz_cvtepi16_epi32(all, k)))
#elif P_WIDTH == 8
    P_EACH(
        __m128i k = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * P_WIDTH));
        a.v[piece] = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(k)))
#else
    P_EACH(
        __m128i k = _mm_loadl_epi64((const __m128i *)(const void *)(from + piece * P_WIDTH));
        a.v[piece] = _mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(k, k), 16)))
#endif
    return a;
}

/* Returns from[k] for each lane's k. */
static inline P_IN_KERNEL P_lanes P_lanes_gather(const float *from, P_lane_ints k)
{
    P_lanes a;
#if P_WIDTH == 16
    float each[16];                             /* gcc 12's gather warns of itself */
    int32_t at[16];
    int l;
    P_EACH(
        _mm512_storeu_si512((void *)at, k.v[piece]);
        for (l = 0; l < 16; l++) each[l] = from[at[l]];
        a.v[piece] = _mm512_loadu_ps(each))
#elif P_WIDTH == 8
    P_EACH(a.v[piece] = _mm256_i32gather_ps(from, k.v[piece], 4))
#else
    int32_t at[4];
    P_EACH(
        _mm_storeu_si128((__m128i *)(void *)at, k.v[piece]);
        a.v[piece] = _mm_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lane_mask P_mask_and(P_lane_mask m, P_lane_mask n)
{
#if P_WIDTH == 16
    P_EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    P_EACH(m.v[piece] = P_INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_mask_or(P_lane_mask m, P_lane_mask n)
{
#if P_WIDTH == 16
    P_EACH(m.v[piece] = (__mmask16)(m.v[piece] | n.v[piece]))
#else
    P_EACH(m.v[piece] = P_INTEL(or_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline P_IN_KERNEL uint32_t P_mask_bits(P_lane_mask m)
{
    uint32_t bits = 0;
#if P_WIDTH == 16
    P_EACH(bits |= (uint32_t)m.v[piece] << piece * P_WIDTH)
#else
    P_EACH(bits |= (uint32_t)P_INTEL(movemask_ps)(m.v[piece]) << piece * P_WIDTH)
#endif
    return bits;
}

static inline P_IN_KERNEL P_lane_mask P_mask_of_bits(uint32_t bits)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = (__mmask16)(bits >> piece * P_WIDTH))
#elif P_WIDTH == 8
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    P_EACH(
        __m256i k = _mm256_and_si256(_mm256_set1_epi32((int32_t)(bits >> piece * P_WIDTH)), each);
        m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k, each)))
#else
    const __m128i each = _mm_setr_epi32(1, 2, 4, 8);
    P_EACH(
        __m128i k = _mm_and_si128(_mm_set1_epi32((int32_t)(bits >> piece * P_WIDTH)), each);
        m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k, each)))
#endif
    return m;
}

static inline P_IN_KERNEL int P_mask_any(P_lane_mask m)
{
    int any = 0;
#if P_WIDTH == 16
    P_EACH(any |= m.v[piece])
#else
    P_EACH(any |= P_INTEL(movemask_ps)(m.v[piece]))
#endif
    return any != 0;
}

static inline P_IN_KERNEL P_lane_ints P_ints_load(const int32_t *from)
{
    P_lane_ints k;
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_loadu_si512((const void *)(from + piece * P_WIDTH)))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * P_WIDTH)))
#else
    P_EACH(k.v[piece] = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * P_WIDTH)))
#endif
    return k;
}

static inline P_IN_KERNEL void P_ints_store(int32_t *to, P_lane_ints k)
{
#if P_WIDTH == 16
    P_EACH(_mm512_storeu_si512((void *)(to + piece * P_WIDTH), k.v[piece]))
#elif P_WIDTH == 8
    P_EACH(_mm256_storeu_si256((__m256i *)(void *)(to + piece * P_WIDTH), k.v[piece]))
#else
    P_EACH(_mm_storeu_si128((__m128i *)(void *)(to + piece * P_WIDTH), k.v[piece]))
#endif
}

static inline P_IN_KERNEL P_lane_ints P_ints_all(int32_t x)
{
    P_lane_ints k;
    P_EACH(k.v[piece] = P_INTEL(set1_epi32)(x))
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_add(P_lane_ints k, P_lane_ints n)
{
    P_EACH(k.v[piece] = P_INTEL(add_epi32)(k.v[piece], n.v[piece]))
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_sub(P_lane_ints k, P_lane_ints n)
{
    P_EACH(k.v[piece] = P_INTEL(sub_epi32)(k.v[piece], n.v[piece]))
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_or(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_or_si512(k.v[piece], n.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_or_si256(k.v[piece], n.v[piece]))
#else
    P_EACH(k.v[piece] = _mm_or_si128(k.v[piece], n.v[piece]))
#endif
    return k;
}

/* Returns m ? k : 0. */
static inline P_IN_KERNEL P_lane_ints P_ints_keep(P_lane_mask m, P_lane_ints k)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_maskz_mov_epi32(m.v[piece], k.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_and_si256(_mm256_castps_si256(m.v[piece]), k.v[piece]))
#else
    P_EACH(k.v[piece] = _mm_and_si128(_mm_castps_si128(m.v[piece]), k.v[piece]))
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_mask P_ints_equal(P_lane_ints k, P_lane_ints n)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = _mm512_cmpeq_epi32_mask(k.v[piece], n.v[piece]))
#elif P_WIDTH == 8
    P_EACH(m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k.v[piece], n.v[piece])))
#else
    P_EACH(m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k.v[piece], n.v[piece])))
#endif
    return m;
}

#endif
