/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef P_KERNEL
#undef P_IN_KERNEL
#undef P_IN_LARGE_KERNEL
#undef P_INTEL
#undef P_EACH

#if P_WIDTH == 16
#define P_KERNEL P_TARGET_AVX512
#elif P_WIDTH == 8
#define P_KERNEL P_TARGET_AVX2
#else
#define P_KERNEL
#endif

#if P_WIDTH == 16
#define P_INTEL(name) _mm512_##name
#elif P_WIDTH == 8
#define P_INTEL(name) _mm256_##name
#else
#define P_INTEL(name) _mm_##name
#endif

/* P_IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
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

/* P_EACH executes statements for every piece of P_WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if P_WIDTH > 1 && P_LANE_COUNT == P_WIDTH
#define P_EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif P_WIDTH > 1 && P_LANE_COUNT == 2 * P_WIDTH
#define P_EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif P_WIDTH > 1 && P_LANE_COUNT == 4 * P_WIDTH
#define P_EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define P_EACH(...) \
    { int piece; for (piece = 0; piece < P_LANE_COUNT / P_WIDTH; piece++) { __VA_ARGS__; } }
#endif
