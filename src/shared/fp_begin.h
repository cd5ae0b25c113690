/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* No fused multiply-add that the source does not ask for: gcc fuses across statements in its gnu modes and on s390x,
   clang within expressions. A user's -ffast-math is taken back in gcc; in clang it, or -ffp-contract=fast, wins over
   the pragma: results then stay within tolerance but not equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define P_FINITE_MATH 1
#else
#define P_FINITE_MATH 0
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(__TINYC__)
#pragma GCC push_options
#pragma GCC optimize("-ffp-contract=off", "-fno-fast-math", "-fno-trapping-math")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif
