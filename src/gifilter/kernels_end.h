#undef GIFILT__SET
#undef GIFILT__WIDTH
#undef GIFILT__LANE_COUNT
#endif /* GIFILT__SET */

#if defined(GIFILTER_IMPLEMENTATION) && !defined(GIFILTER_IMPLEMENTED)
#define GIFILTER_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if GIFILT__SIMD_SETS
#define GIFILT__SET avx2
#define GIFILT__WIDTH 8
#define GIFILT__LANE_COUNT 8
#include GIFILT__FILE
#define GIFILT__SET avx512
#define GIFILT__WIDTH 16
#define GIFILT__LANE_COUNT 16
#include GIFILT__FILE
#endif

static inline void gifilt__choose_filter(gifilt__filter_run *r)
{
    r->accumulate = gifilt__accumulate_plain;
    r->smooth = gifilt__smooth_plain;
#if GIFILT__SIMD_SETS
    if (gifilt__simd_level() == 1) {
        r->accumulate = gifilt__accumulate_avx2;
        r->smooth = gifilt__smooth_avx2;
    }
    if (gifilt__simd_level() == 2) {
        r->accumulate = gifilt__accumulate_avx512;
        r->smooth = gifilt__smooth_avx512;
    }
#endif
}
