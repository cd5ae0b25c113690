/* unit simd_ints, needs simd_begin bits: whole numbers in lanes, lanes of a mask in a row, single bits */

#define P_ints_mul P_NAME_IN_SET(P_ints_mul, P_SET)
#define P_ints_greater P_NAME_IN_SET(P_ints_greater, P_SET)
#define P_ints_select P_NAME_IN_SET(P_ints_select, P_SET)
#define P_ints_min P_NAME_IN_SET(P_ints_min, P_SET)
#define P_ints_max P_NAME_IN_SET(P_ints_max, P_SET)
#define P_ints_shift_right P_NAME_IN_SET(P_ints_shift_right, P_SET)
#define P_ints_append P_NAME_IN_SET(P_ints_append, P_SET)
#define P_lanes_append P_NAME_IN_SET(P_lanes_append, P_SET)
#define P_lanes_first P_NAME_IN_SET(P_lanes_first, P_SET)
#define P_mask_count P_NAME_IN_SET(P_mask_count, P_SET)
#define P_first_bit P_NAME_IN_SET(P_first_bit, P_SET)
#define P_bit_count P_NAME_IN_SET(P_bit_count, P_SET)
#define P_nth_bit P_NAME_IN_SET(P_nth_bit, P_SET)
#define P_halves_of16 P_NAME_IN_SET(P_halves_of16, P_SET)
#define P_halves_up_to P_NAME_IN_SET(P_halves_up_to, P_SET)
#define P_ints_and P_NAME_IN_SET(P_ints_and, P_SET)
#define P_ints_xor P_NAME_IN_SET(P_ints_xor, P_SET)
#define P_ints_join_halves P_NAME_IN_SET(P_ints_join_halves, P_SET)
#define P_ints_cross_halves P_NAME_IN_SET(P_ints_cross_halves, P_SET)
#define P_ints_gather P_NAME_IN_SET(P_ints_gather, P_SET)

/* Returns the low 32 bits of products, so that signs do not matter. */
static inline P_IN_KERNEL P_lane_ints P_ints_mul(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH > 4
    P_EACH(k.v[piece] = P_INTEL(mullo_epi32)(k.v[piece], n.v[piece]))
#elif P_SIMD_X86                            /* SSE2 has products of lanes 0 and 2, in 64 bits */
    P_EACH(
        const __m128i even = _mm_mul_epu32(k.v[piece], n.v[piece]);
        const __m128i odd = _mm_mul_epu32(_mm_srli_epi64(k.v[piece], 32), _mm_srli_epi64(n.v[piece], 32));
        k.v[piece] = _mm_unpacklo_epi32(_mm_shuffle_epi32(even, 8), _mm_shuffle_epi32(odd, 8)))
#else
    P_EACH(k.v[piece] = (P_piece_ints)((P_piece_words)k.v[piece] * (P_piece_words)n.v[piece]))
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_mask P_ints_greater(P_lane_ints k, P_lane_ints n)
{
    P_lane_mask m;
#if P_WIDTH == 16
    P_EACH(m.v[piece] = _mm512_cmpgt_epi32_mask(k.v[piece], n.v[piece]))
#elif P_WIDTH == 8
    P_EACH(m.v[piece] = _mm256_castsi256_ps(_mm256_cmpgt_epi32(k.v[piece], n.v[piece])))
#elif P_SIMD_X86
    P_EACH(m.v[piece] = _mm_castsi128_ps(_mm_cmpgt_epi32(k.v[piece], n.v[piece])))
#elif P_SIMD_VECTORS
    P_EACH(m.v[piece] = k.v[piece] > n.v[piece])
#else
    P_EACH(m.v[piece] = -(k.v[piece] > n.v[piece]))
#endif
    return m;
}

/* Returns m ? k : n in each lane. */
static inline P_IN_KERNEL P_lane_ints P_ints_select(P_lane_mask m, P_lane_ints k,
                                                    P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_mask_mov_epi32(n.v[piece], m.v[piece], k.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_blendv_epi8(n.v[piece], k.v[piece], _mm256_castps_si256(m.v[piece])))
#elif P_SIMD_X86
    P_EACH(
        const __m128i mask = _mm_castps_si128(m.v[piece]);
        k.v[piece] = _mm_or_si128(_mm_and_si128(mask, k.v[piece]), _mm_andnot_si128(mask, n.v[piece])))
#else
    P_EACH(k.v[piece] = (m.v[piece] & k.v[piece]) | (~m.v[piece] & n.v[piece]))
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_min(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    P_EACH(k.v[piece] = _mm512_maskz_min_epi32((__mmask16)0xffff, k.v[piece], n.v[piece]))
    return k;
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_min_epi32(k.v[piece], n.v[piece]))
    return k;
#else
    return P_ints_select(P_ints_greater(n, k), k, n);
#endif
}

static inline P_IN_KERNEL P_lane_ints P_ints_max(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_maskz_max_epi32((__mmask16)0xffff, k.v[piece], n.v[piece]))
    return k;
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_max_epi32(k.v[piece], n.v[piece]))
    return k;
#else
    return P_ints_select(P_ints_greater(k, n), k, n);
#endif
}

/* Returns k / 2^n, rounded down. */
static inline P_IN_KERNEL P_lane_ints P_ints_shift_right(P_lane_ints k, int n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_maskz_srav_epi32((__mmask16)0xffff, k.v[piece], _mm512_set1_epi32(n)))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_srai_epi32(k.v[piece], n))
#elif P_SIMD_X86
    P_EACH(k.v[piece] = _mm_srai_epi32(k.v[piece], n))
#else
    P_EACH(k.v[piece] = k.v[piece] >> n)
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_and(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_and_si512(k.v[piece], n.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_and_si256(k.v[piece], n.v[piece]))
#elif P_SIMD_X86
    P_EACH(k.v[piece] = _mm_and_si128(k.v[piece], n.v[piece]))
#else
    P_EACH(k.v[piece] = k.v[piece] & n.v[piece])
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_xor(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(k.v[piece] = _mm512_xor_si512(k.v[piece], n.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_xor_si256(k.v[piece], n.v[piece]))
#elif P_SIMD_X86
    P_EACH(k.v[piece] = _mm_xor_si128(k.v[piece], n.v[piece]))
#else
    P_EACH(k.v[piece] = k.v[piece] ^ n.v[piece])
#endif
    return k;
}

/* Returns the low halves of k below those of n. */
static inline P_IN_KERNEL P_lane_ints P_ints_join_halves(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(
        const __m512i high = _mm512_maskz_slli_epi32((__mmask16)0xffff, n.v[piece], 16);
        k.v[piece] = _mm512_mask_blend_epi16((__mmask32)0x55555555, high, k.v[piece]))
#elif P_WIDTH == 8
    P_EACH(k.v[piece] = _mm256_blend_epi16(_mm256_slli_epi32(n.v[piece], 16), k.v[piece], 0x55))
#elif P_SIMD_X86
    P_EACH(k.v[piece] = _mm_or_si128(_mm_slli_epi32(n.v[piece], 16),
                                     _mm_and_si128(k.v[piece], _mm_set1_epi32(0xffff))))
#else
    P_EACH(
        const P_piece_words high = (P_piece_words)n.v[piece] << 16;
        k.v[piece] = (P_piece_ints)(high | ((P_piece_words)k.v[piece] & 0xffffu)))
#endif
    return k;
}

/* Returns kx ny - nx ky, where x is the low half of a number and y the high half, both with a sign; x of n is
   not the least that a half can be. */
static inline P_IN_KERNEL P_lane_ints P_ints_cross_halves(P_lane_ints k, P_lane_ints n)
{
#if P_WIDTH == 16
    P_EACH(
        const __m512i turned = _mm512_maskz_rol_epi32((__mmask16)0xffff, n.v[piece], 16);
        const __m512i zero = _mm512_setzero_si512();
        k.v[piece] = _mm512_madd_epi16(
            k.v[piece], _mm512_mask_sub_epi16(turned, (__mmask32)0xaaaaaaaau, zero, turned)))
#elif P_WIDTH == 8
    P_EACH(
        const __m256i turned = _mm256_shufflehi_epi16(_mm256_shufflelo_epi16(n.v[piece], 0xb1), 0xb1);
        k.v[piece] = _mm256_madd_epi16(
            k.v[piece], _mm256_sign_epi16(turned, _mm256_set1_epi32((int)0xffff0001u))))
#elif P_SIMD_X86
    P_EACH(
        const __m128i y = _mm_srli_epi32(n.v[piece], 16), x = _mm_slli_epi32(n.v[piece], 16);
        k.v[piece] = _mm_madd_epi16(k.v[piece], _mm_or_si128(y, _mm_sub_epi32(_mm_setzero_si128(), x))))
#else
    P_EACH(
        const P_piece_ints kx = (P_piece_ints)((P_piece_words)k.v[piece] << 16) >> 16;
        const P_piece_ints nx = (P_piece_ints)((P_piece_words)n.v[piece] << 16) >> 16;
        k.v[piece] = kx * (n.v[piece] >> 16) - nx * (k.v[piece] >> 16))
#endif
    return k;
}

/* Returns from[k] for each lane's k. */
static inline P_IN_KERNEL P_lane_ints P_ints_gather(const int32_t *from, P_lane_ints at)
{
#if P_WIDTH == 16 && (defined(__OPTIMIZE__) || !defined(__GNUC__) || defined(__clang__))
    const __m512i none = _mm512_setzero_si512();        /* the gather of gcc -O0 turns signs */
    P_EACH(at.v[piece] = _mm512_mask_i32gather_epi32(
               none, (__mmask16)0xffff, at.v[piece], (const void *)from, 4))
    return at;
#elif P_WIDTH == 8
    P_EACH(at.v[piece] = _mm256_i32gather_epi32((const int *)from, at.v[piece], 4))
    return at;
#else
    int32_t all[P_LANE_COUNT];
    int l;
    P_ints_store(all, at);
    for (l = 0; l < P_LANE_COUNT; l++) all[l] = from[all[l]];
    return P_ints_load(all);
#endif
}

/* Returns how many lanes are in a mask. */
static inline P_IN_KERNEL uint32_t P_mask_count(P_lane_mask m)
{
#if P_WIDTH > 4
    return (uint32_t)_mm_popcnt_u32(P_mask_bits(m));
#else
    return P_popcount(P_mask_bits(m));
#endif
}

/* Returns the number of the lowest set bit; bits is not 0. */
static inline P_IN_KERNEL uint32_t P_first_bit(uint32_t bits)
{
#if P_WIDTH > 4
    return _tzcnt_u32(bits);
#elif defined(__GNUC__) && !defined(__TINYC__)
    return (uint32_t)__builtin_ctz(bits);
#else
    return P_popcount(~bits & (bits - 1u));
#endif
}

static inline P_IN_KERNEL uint32_t P_bit_count(uint64_t bits)
{
#if P_WIDTH > 4 && (defined(__x86_64__) || defined(_M_X64))
    return (uint32_t)_mm_popcnt_u64(bits);
#else
    return P_popcount(bits);
#endif
}

/* Does what P_select_bit does, for a number below 64. */
static inline P_IN_KERNEL uint32_t P_nth_bit(uint64_t bits, uint32_t number)
{
#if P_WIDTH > 4 && (defined(__x86_64__) || defined(_M_X64))
    return (uint32_t)_tzcnt_u64(_pdep_u64((uint64_t)1 << (number & 63u), bits));
#else
    return P_select_bit(bits, number);
#endif
}

#if P_WIDTH > 4
/* Does what P_halves_up_to does for the half words of sixteen words, of which the first count are there. */
static inline P_IN_KERNEL uint32_t P_halves_of16(const uint32_t *words, uint32_t count, uint32_t limit)
{
    const __m256i limits = _mm256_set1_epi16((short)limit);
    const __m256i end = _mm256_set1_epi16((short)(count < 32u ? count : 32u));
    const __m256i number = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)words);
    __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(words + 8));
    a = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(a, limits), a), _mm256_cmpgt_epi16(end, number));
    b = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(b, limits), b),
                         _mm256_cmpgt_epi16(end, _mm256_add_epi16(number, _mm256_set1_epi16(16))));
    return (uint32_t)_mm_popcnt_u32((uint32_t)_mm256_movemask_epi8(_mm256_packs_epi16(a, b)));
}
#endif

/* Returns how many of the first count half words, which ascend, the low half of each word first, are at most
   the limit. Words are read sixteen at a time. */
static inline P_IN_KERNEL uint32_t P_halves_up_to(const uint32_t *words, uint32_t count, uint32_t limit)
{
#if P_WIDTH > 4
    uint32_t n = P_halves_of16(words, count, limit), at;
    for (at = 32; at < count; at += 32) n += P_halves_of16(words + at / 2, count - at, limit);
#else
    uint32_t n = 0, half, at;
    for (count++; count > 1; count -= half) {               /* halving without branches */
        half = count / 2;
        at = n + half - 1u;
        n += half & (0u - (uint32_t)((words[at >> 1] >> 16 * (at & 1u) & 0xffffu) <= limit));
    }
#endif
    return n;
}

#if P_WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
/* Returns the numbers of the lanes that are in a mask, one after the other from lane 0 on. */
static inline P_IN_KERNEL __m256i P_lanes_first(uint32_t bits)
{
    const uint64_t bytes = _pext_u64(0x0706050403020100u, _pdep_u64(bits, 0x0101010101010101u) * 255u);
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)bytes));
}
#endif

/* Writes the lanes of a mask one after the other. After them anything may be written, up to as many floats
   as there are lanes. */
static inline P_IN_KERNEL void P_lanes_append(float *to, P_lane_mask m, P_lanes a)
{
#if P_WIDTH == 16
    P_EACH(
        _mm512_storeu_ps(to, _mm512_maskz_compress_ps(m.v[piece], a.v[piece]));
        to += _mm_popcnt_u32(m.v[piece]))
#elif P_WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
    P_EACH(
        const uint32_t bits = (uint32_t)_mm256_movemask_ps(m.v[piece]);
        _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(a.v[piece], P_lanes_first(bits)));
        to += _mm_popcnt_u32(bits))
#else
    float all[P_LANE_COUNT];
    uint32_t bits = P_mask_bits(m);
    P_lanes_store(all, a);
    for (; bits; bits &= bits - 1u) *to++ = all[P_first_bit(bits)];
#endif
}

static inline P_IN_KERNEL void P_ints_append(int32_t *to, P_lane_mask m, P_lane_ints k)
{
#if P_WIDTH == 16
    P_EACH(
        _mm512_storeu_si512((void *)to, _mm512_maskz_compress_epi32(m.v[piece], k.v[piece]));
        to += _mm_popcnt_u32(m.v[piece]))
#elif P_WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
    P_EACH(
        const uint32_t bits = (uint32_t)_mm256_movemask_ps(m.v[piece]);
        const __m256i first = _mm256_permutevar8x32_epi32(k.v[piece], P_lanes_first(bits));
        _mm256_storeu_si256((__m256i *)(void *)to, first);
        to += _mm_popcnt_u32(bits))
#else
    int32_t all[P_LANE_COUNT];
    uint32_t bits = P_mask_bits(m);
    P_ints_store(all, k);
    for (; bits; bits &= bits - 1u) *to++ = all[P_first_bit(bits)];
#endif
}
