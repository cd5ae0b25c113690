#undef SFIELD__SET
#undef SFIELD__WIDTH
#undef SFIELD__LANE_COUNT
#endif /* SFIELD__SET */

#if defined(SHADOWFIELD_IMPLEMENTATION) && !defined(SHADOWFIELD_IMPLEMENTED)
#define SHADOWFIELD_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if SFIELD__SIMD_SETS
#define SFIELD__SET avx2
#define SFIELD__WIDTH 8
#define SFIELD__LANE_COUNT 16
#include SFIELD__FILE
#define SFIELD__SET avx512
#define SFIELD__WIDTH 16
#define SFIELD__LANE_COUNT 16
#include SFIELD__FILE
#endif

static void sfield__product16(const sfield_algebra *t, const float *a, const float *b, float *out,
                              size_t stride, int occlude)
{
#if SFIELD__SIMD_SETS
    if (t->simd == 2) {
        (t->bands == 4 ? sfield__product4_avx512 : sfield__product_avx512)(t, a, b, out, stride, occlude);
        return;
    }
    if (t->simd == 1) {
        (t->bands == 4 ? sfield__product4_avx2 : sfield__product_avx2)(t, a, b, out, stride, occlude);
        return;
    }
#endif
    sfield__product_plain(t, a, b, out, stride, occlude);
}

static void sfield__rotate16(const sfield_rotation *r, const float *in, float *out, size_t stride,
                             int inverse, int simd)
{
#if SFIELD__SIMD_SETS
    if (simd == 2) {
        (r->bands == 4 ? sfield__rotate4_avx512 : sfield__rotate_avx512)(r, in, out, stride, inverse);
        return;
    }
    if (simd == 1) {
        (r->bands == 4 ? sfield__rotate4_avx2 : sfield__rotate_avx2)(r, in, out, stride, inverse);
        return;
    }
#endif
    (void)simd;
    (r->bands == 4 ? sfield__rotate4_plain : sfield__rotate_plain)(r, in, out, stride, inverse);
}

static void sfield__mix_eight(const sfield__eight *c, const sfield__place *at, const float *factor, int more,
                              float *out, int simd)
{
#if SFIELD__SIMD_SETS
    if (simd) {
        (simd == 2 ? sfield__eight_to_planes_avx512 : sfield__eight_to_planes_avx2)(c, at, factor, more, out);
        return;
    }
#endif
    (void)simd;
    sfield__eight_to_planes_plain(c, at, factor, more, out);
}

static void sfield__dot_eight(const sfield__eight *c, const sfield__place *at, const float *factor,
                              const float *t, float *sum, int simd)
{
#if SFIELD__SIMD_SETS
    if (simd) {
        (simd == 2 ? sfield__eight_times_avx512 : sfield__eight_times_avx2)(c, at, factor, t, sum);
        return;
    }
#endif
    (void)simd;
    sfield__eight_times_plain(c, at, factor, t, sum);
}

/* Calls a kernel that has no text of its own for AVX-512. */
#if SFIELD__SIMD_SETS
#define SFIELD__CALL(kernel, simd, arguments) ((simd) ? kernel##_avx2 arguments : kernel##_plain arguments)
#else
#define SFIELD__CALL(kernel, simd, arguments) ((void)(simd), kernel##_plain arguments)
#endif

static void sfield__locate16(const sfield_field *f, const float *p, sfield__place *out, int simd)
{
    SFIELD__CALL(sfield__locate, simd, (f, p, out));
}

static uint32_t sfield__same16(const int32_t *base, int32_t wanted, int simd)
{
    return SFIELD__CALL(sfield__same_eight, simd, (base, wanted));
}

static void sfield__select16(const float *in, uint32_t n, uint32_t mask, float *out, int simd)
{
    SFIELD__CALL(sfield__select, simd, (in, n, mask, out));
}

static void sfield__to_local16(const float *m, const float *c, float f, const float *p, float *local,
                               int simd)
{
    SFIELD__CALL(sfield__to_local, simd, (m, c, f, p, local));
}

static uint32_t sfield__nearer16(const float *a, const float *b, int simd)
{
    return SFIELD__CALL(sfield__nearer, simd, (a, b));
}

static uint32_t sfield__look_at16(const float *p, const float *n, const float *c, float reach2, float low,
                                  float *d2, int simd)
{
    return SFIELD__CALL(sfield__look_at, simd, (p, n, c, reach2, low, d2));
}

static void sfield__fade16(const float *d2, float inverse_reach, uint32_t lanes, float *factor, int simd)
{
    SFIELD__CALL(sfield__fade, simd, (d2, inverse_reach, lanes, factor));
}

static void sfield__recall16(const int16_t *value, const float *scale, uint32_t n, float *t, int simd)
{
#if SFIELD__SIMD_SETS
    if (simd == 2) {
        sfield__recall_avx512(value, scale, n, t);
        return;
    }
#endif
    SFIELD__CALL(sfield__recall, simd, (value, scale, n, t));
}
