/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for P_lanes: P_LANE_COUNT floats, of which the instruction set P_SET
   computes P_WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if P_SIMD_SETS is 1, the header includes itself with P_SET, P_WIDTH and P_LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. P_simd_level returns which set to call. With P_NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if P_COMPILER_VECTORS is
   defined. P_FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes P_lanes_add the name
   P_lanes_add_avx2 in set avx2; the header has such a list for its kernels. P_KERNEL stands before a
   kernel, P_IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for P_lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(P_NO_SIMD) && (!defined(P_COMPILER_VECTORS) || defined(__i386__))
#define P_SCALAR 1
#else
#define P_SCALAR 0
#endif
#if P_X86
#include <immintrin.h>
#define P_SIMD_SETS 1
#else
#define P_SIMD_SETS 0
#endif
#if P_X86 && (defined(__x86_64__) || defined(_M_X64))
#define P_SIMD_X86 1
#define P_SIMD_VECTORS 0
#define P_SIMD_WIDTH 4
#elif !P_X86 && !P_SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define P_SIMD_X86 0
#define P_SIMD_VECTORS 1
#define P_SIMD_WIDTH 4
#else
#define P_SIMD_X86 0
#define P_SIMD_VECTORS 0
#define P_SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(P_FILE)
#undef P_SIMD_SETS
#define P_SIMD_SETS 0
#endif
#endif
#if P_SIMD_VECTORS && defined(__aarch64__) && !defined(P_NO_SIMD)
#include <arm_neon.h>
#elif P_SIMD_VECTORS && defined(__wasm_simd128__) && !defined(P_NO_SIMD)
#include <wasm_simd128.h>
#endif

#define P_NAME_OF_SET(name, set) name##_##set
#define P_NAME_IN_SET(name, set) P_NAME_OF_SET(name, set)
#define P_lanes P_NAME_IN_SET(P_lanes, P_SET)
#define P_lane_mask P_NAME_IN_SET(P_lane_mask, P_SET)
#define P_lane_ints P_NAME_IN_SET(P_lane_ints, P_SET)
#define P_piece P_NAME_IN_SET(P_piece, P_SET)
#define P_piece_ints P_NAME_IN_SET(P_piece_ints, P_SET)
#define P_piece_words P_NAME_IN_SET(P_piece_words, P_SET)
#define P_lanes_load P_NAME_IN_SET(P_lanes_load, P_SET)
#define P_lanes_store P_NAME_IN_SET(P_lanes_store, P_SET)
#define P_lanes_all P_NAME_IN_SET(P_lanes_all, P_SET)
#define P_lanes_add P_NAME_IN_SET(P_lanes_add, P_SET)
#define P_lanes_sub P_NAME_IN_SET(P_lanes_sub, P_SET)
#define P_lanes_mul P_NAME_IN_SET(P_lanes_mul, P_SET)
#define P_lanes_div P_NAME_IN_SET(P_lanes_div, P_SET)
#define P_lanes_muladd P_NAME_IN_SET(P_lanes_muladd, P_SET)
#define P_lanes_max P_NAME_IN_SET(P_lanes_max, P_SET)
#define P_lanes_min P_NAME_IN_SET(P_lanes_min, P_SET)
#define P_lanes_sqrt P_NAME_IN_SET(P_lanes_sqrt, P_SET)
#define P_lanes_abs P_NAME_IN_SET(P_lanes_abs, P_SET)
#define P_lanes_negate P_NAME_IN_SET(P_lanes_negate, P_SET)
#define P_lanes_greater P_NAME_IN_SET(P_lanes_greater, P_SET)
#define P_lanes_at_least P_NAME_IN_SET(P_lanes_at_least, P_SET)
#define P_lanes_differ P_NAME_IN_SET(P_lanes_differ, P_SET)
#define P_lanes_select P_NAME_IN_SET(P_lanes_select, P_SET)
#define P_lanes_keep P_NAME_IN_SET(P_lanes_keep, P_SET)
#define P_lanes_truncate P_NAME_IN_SET(P_lanes_truncate, P_SET)
#define P_lanes_of_ints P_NAME_IN_SET(P_lanes_of_ints, P_SET)
#define P_lanes_of_shorts P_NAME_IN_SET(P_lanes_of_shorts, P_SET)
#define P_lanes_gather P_NAME_IN_SET(P_lanes_gather, P_SET)
#define P_lanes3 P_NAME_IN_SET(P_lanes3, P_SET)
#define P_lanes3_load P_NAME_IN_SET(P_lanes3_load, P_SET)
#define P_lanes3_load_packed P_NAME_IN_SET(P_lanes3_load_packed, P_SET)
#define P_lanes3_all P_NAME_IN_SET(P_lanes3_all, P_SET)
#define P_lanes3_scale P_NAME_IN_SET(P_lanes3_scale, P_SET)
#define P_lanes3_sub P_NAME_IN_SET(P_lanes3_sub, P_SET)
#define P_lanes3_store_packed P_NAME_IN_SET(P_lanes3_store_packed, P_SET)
#define P_lanes3_dot P_NAME_IN_SET(P_lanes3_dot, P_SET)
#define P_mask_and P_NAME_IN_SET(P_mask_and, P_SET)
#define P_mask_or P_NAME_IN_SET(P_mask_or, P_SET)
#define P_mask_any P_NAME_IN_SET(P_mask_any, P_SET)
#define P_mask_bits P_NAME_IN_SET(P_mask_bits, P_SET)
#define P_mask_of_bits P_NAME_IN_SET(P_mask_of_bits, P_SET)
#define P_ints_load P_NAME_IN_SET(P_ints_load, P_SET)
#define P_ints_store P_NAME_IN_SET(P_ints_store, P_SET)
#define P_ints_all P_NAME_IN_SET(P_ints_all, P_SET)
#define P_ints_add P_NAME_IN_SET(P_ints_add, P_SET)
#define P_ints_sub P_NAME_IN_SET(P_ints_sub, P_SET)
#define P_ints_or P_NAME_IN_SET(P_ints_or, P_SET)
#define P_ints_keep P_NAME_IN_SET(P_ints_keep, P_SET)
#define P_ints_equal P_NAME_IN_SET(P_ints_equal, P_SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int P_simd_level(void)
{
    if (!P_SIMD_SETS || !P_cpu_has_avx2()) return 0;
    return P_cpu_has_avx512() ? 2 : 1;
}
