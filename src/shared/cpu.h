/* unit cpu: run-time detection of x86 vector units */

/* P_X86 is 1 where functions with target attributes can be compiled and chosen at run time.
   P_NO_SIMD, defined by the header from its public switch, leaves all of it out. tcc has no attributes; MSVC
   needs none. clang in MSVC's place (clang-cl) hides the vector types unless all is built for them. */
#if !defined(P_NO_SIMD) && (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__) && !defined(__TINYC__)
#define P_X86 1
#define P_TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define P_TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif !defined(P_NO_SIMD) && defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define P_X86 1
#define P_TARGET_AVX2
#define P_TARGET_AVX512
#else
#define P_X86 0
#endif

#if P_X86 && defined(_MSC_VER)
#include <intrin.h>
/* Bit of leaf 7's ebx, after FMA and what the operating system saves were checked. */
static inline int P_cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    int r[4];
    __cpuid(r, 0);
    if (r[0] < 7) return 0;
    __cpuid(r, 1);
    if (!(r[2] & 1 << 12) || !(r[2] & 1 << 27) || !(r[2] & 1 << 23)) return 0;   /* FMA, OSXSAVE, POPCNT */
    if (((unsigned)_xgetbv(0) & xcr0) != xcr0) return 0;
    __cpuidex(r, 7, 0);
    return ((unsigned)r[1] & ebx) == ebx;
}
static inline int P_cpu_has_avx2(void) { return P_cpu_leaf7(0x06u, 0x00000128u); }
static inline int P_cpu_has_avx512(void) { return P_cpu_leaf7(0xe6u, 0xc0030128u); }
#elif P_X86
/* The compiler's run time asks the operating system too. Every processor with BMI2 has LZCNT. */
static inline int P_cpu_has_avx2(void)
{
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}
static inline int P_cpu_has_avx512(void)
{
    return P_cpu_has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
static inline int P_cpu_has_avx2(void) { return 0; }
static inline int P_cpu_has_avx512(void) { return 0; }
#endif
