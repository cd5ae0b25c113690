/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef P_KERNEL
#undef P_IN_KERNEL
#undef P_IN_LARGE_KERNEL
#undef P_INTEL
#undef P_EACH

#if P_WIDTH == 16
#define P_KERNEL P_TARGET_AVX512
#define P_INTEL(name) _mm512_##name
#elif P_WIDTH == 8
#define P_KERNEL P_TARGET_AVX2
#define P_INTEL(name) _mm256_##name
#else
#define P_KERNEL
#define P_INTEL(name) _mm_##name
#endif

/* P_IN_LARGE_KERNEL stands behind static before what a kernel calls dozens of times. Without optimisation, and with
   gcc's sanitizers, which take minutes to build large functions, this is not inlined. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define P_IN_KERNEL __attribute__((always_inline)) P_KERNEL
#else
#define P_IN_KERNEL P_KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define P_IN_LARGE_KERNEL __attribute__((noinline)) P_KERNEL
#else
#define P_IN_LARGE_KERNEL inline P_IN_KERNEL
#endif

/* Does something with every piece of P_WIDTH lanes. With constants for the pieces, so that compilers keep them in
   registers. */
#if P_WIDTH > 1 && P_LANE_COUNT == P_WIDTH
#define P_EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif P_WIDTH > 1 && P_LANE_COUNT == 2 * P_WIDTH
#define P_EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif P_WIDTH > 1 && P_LANE_COUNT == 4 * P_WIDTH
#define P_EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define P_EACH(...) { int piece; for (piece = 0; piece < P_LANE_COUNT / P_WIDTH; piece++) { __VA_ARGS__; } }
#endif
