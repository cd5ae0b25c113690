#undef ISM__SET
#undef ISM__WIDTH
#undef ISM__LANE_COUNT
#endif /* ISM__SET */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)
#define ISM_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if ISM__SIMD_SETS
#define ISM__SET avx2
#define ISM__WIDTH 8
#define ISM__LANE_COUNT 8
#include ISM__FILE
#define ISM__SET avx512
#define ISM__WIDTH 16
#define ISM__LANE_COUNT 16
#include ISM__FILE
#endif

static ism__splat ism__choose_splat(void)
{
    ism__splat kernels = { ism__place_discs_plain, ism__draw_discs_plain };
#if ISM__SIMD_SETS
    const int level = ism__simd_level();
    if (level) {
        kernels.place = level == 2 ? ism__place_discs_avx512 : ism__place_discs_avx2;
        kernels.draw = ism__draw_discs_avx2;
    }
#endif
    return kernels;
}

static void ism__choose_spread(ism__spread_work *w)
{
#if ISM__SIMD_SETS
    const int level = ism__simd_level();
#endif
    w->mean_solid_angle = ism__mean_solid_angle_plain;
#if ISM__SIMD_SETS
    if (level) w->mean_solid_angle = ism__mean_solid_angle_avx2;
#endif
#ifndef ISM_WITHOUT_PAIR
    w->weigh_clusters = ism__weigh_clusters_plain;
#if ISM__SIMD_SETS
    if (level) w->weigh_clusters = level == 2 ? ism__weigh_clusters_avx512 : ism__weigh_clusters_avx2;
#endif
#endif
}
