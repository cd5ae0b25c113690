/* unit cpu: run-time detection of x86 vector units */

/* P_X86 is 1 if functions with target attributes can be compiled and chosen at run time. P_NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(P_NO_SIMD) || defined(__TINYC__)
#define P_X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define P_X86 1
#define P_TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define P_TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define P_X86 1
#define P_TARGET_AVX2
#define P_TARGET_AVX512
#else
#define P_X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if P_X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void P_cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned P_cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif P_X86
#include <cpuid.h>
static inline void P_cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned P_cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if P_X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int P_cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    P_cpu_ask(0, r);
    if (r[0] < 7) return 0;
    P_cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (P_cpu_xcr0() & xcr0) != xcr0) return 0;
    P_cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int P_cpu_has_avx2(void) { return P_cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int P_cpu_has_avx512(void) { return P_cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int P_cpu_has_avx2(void) { return 0; }
static inline int P_cpu_has_avx512(void) { return 0; }
#endif
