/* unit simd_bytes, needs simd_begin simd_ints: bytes that are compared 32 at a time */

#define P_bytes_up_to P_NAME_IN_SET(P_bytes_up_to, P_SET)

/* Returns how many of the bytes from..from + count - 1 are at most the limit. from and count are below 32;
   all of 32 bytes are read. */
static inline P_IN_KERNEL uint32_t P_bytes_up_to(const uint8_t *bytes, uint32_t from, uint32_t count,
                                                 uint32_t limit)
{
#if P_WIDTH > 4
    const __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)bytes);
    const __m256i least = _mm256_min_epu8(b, _mm256_set1_epi8((char)limit));
    const uint32_t mask = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(least, b));
    return (uint32_t)_mm_popcnt_u32(_bzhi_u32(mask >> from, count));
#elif P_SIMD_X86
    const __m128i limits = _mm_set1_epi8((char)limit);
    const __m128i a = _mm_loadu_si128((const __m128i *)(const void *)bytes);
    const __m128i b = _mm_loadu_si128((const __m128i *)(const void *)(bytes + 16));
    uint32_t mask = (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(a, limits), a));
    mask |= (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(b, limits), b)) << 16;
    return P_bit_count(mask >> from & ((1u << count) - 1u));
#else
    uint8_t n = 0;                          /* bytes throughout, so that compilers vectorise it */
    int i;
    for (i = 0; i < 32; i++)
        n = (uint8_t)(n + ((bytes[i] <= (uint8_t)limit) & ((uint8_t)(i - (int)from) < (uint8_t)count)));
    return n;
#endif
}
