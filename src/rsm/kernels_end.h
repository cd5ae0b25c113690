#undef RSM__SET
#undef RSM__WIDTH
#undef RSM__LANE_COUNT
#endif /* RSM__SET */

#if defined(RSM_IMPLEMENTATION) && !defined(RSM_IMPLEMENTED)
#define RSM_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if RSM__SIMD_SETS
#define RSM__SET avx2
#define RSM__WIDTH 8
#define RSM__LANE_COUNT 8
#include RSM__FILE
#define RSM__SET avx512
#define RSM__WIDTH 16
#define RSM__LANE_COUNT 16
#include RSM__FILE
#endif

static inline rsm__kernel rsm__choose_kernel(int lossy, int nearby)
{
#if RSM__SIMD_SETS
    if (rsm__simd_level() && nearby)
        return lossy ? rsm__sum_lights_near_lossy_avx2 : rsm__sum_lights_near_avx2;
    if (rsm__simd_level()) return lossy ? rsm__sum_lights_lossy_avx2 : rsm__sum_lights_avx2;
#endif
    if (nearby) return lossy ? rsm__sum_lights_near_lossy_plain : rsm__sum_lights_near_plain;
    return lossy ? rsm__sum_lights_lossy_plain : rsm__sum_lights_plain;
}

static inline rsm__receiver_lanes_kernel rsm__choose_receiver_lanes_kernel(int lossy, size_t *lanes)
{
    *lanes = 8;
#if RSM__SIMD_SETS
    if (rsm__simd_level() == 2) {
        *lanes = 16;
        return lossy ? rsm__light_receivers_lossy_avx512 : rsm__light_receivers_avx512;
    }
    if (rsm__simd_level()) return lossy ? rsm__light_receivers_lossy_avx2 : rsm__light_receivers_avx2;
#endif
    return lossy ? rsm__light_receivers_lossy_plain : rsm__light_receivers_plain;
}

static inline rsm__suit_kernel rsm__choose_suit(void)
{
#if RSM__SIMD_SETS
    if (rsm__simd_level()) return rsm__suit_tile_avx2;
#endif
    return rsm__suit_tile_plain;
}
