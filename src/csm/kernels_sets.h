/* ---- kernels: those of AVX2 and AVX-512 ---- */

#if COHSM__SIMD_SETS
#define COHSM__SET avx2
#define COHSM__WIDTH 8
#define COHSM__LANE_COUNT 8
#include COHSM__FILE
#define COHSM__SET avx512
#define COHSM__WIDTH 16
#define COHSM__LANE_COUNT 16
#include COHSM__FILE
#endif
