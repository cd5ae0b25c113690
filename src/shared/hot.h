/* unit hot, needs fp_begin: attributes of functions that take most of the time */

/* P_HOT stands before functions that gcc is to optimise as with -O3. It is nothing under -ffast-math, since
   gcc's -O3 for single functions forgets that unit fp_begin took -ffast-math back, and with the address
   sanitizer, with which -O3 of a kernel takes twice as long as everything else. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_ADDRESS__) && !P_FINITE_MATH
#define P_HOT __attribute__((optimize("O3")))
#else
#define P_HOT
#endif

/* P_INLINE stands before what must be inlined into kernels of several targets. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define P_INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define P_INLINE static __forceinline
#else
#define P_INLINE static inline
#endif

#if defined(__GNUC__) && !defined(__TINYC__)
#define P_PREFETCH(p) __builtin_prefetch(p)
#else
#define P_PREFETCH(p) (void)(p)
#endif
