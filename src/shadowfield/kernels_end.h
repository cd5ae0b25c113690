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

/* Calls a kernel of the best instruction set there is. */
#if SFIELD__SIMD_SETS
#define SFIELD__CALL_BEST(kernel, simd, arguments)                                                         \
    ((simd) == 2 ? kernel##_avx512 arguments                                                               \
                 : (simd) == 1 ? kernel##_avx2 arguments : kernel##_plain arguments)
#else
#define SFIELD__CALL_BEST(kernel, simd, arguments) ((void)(simd), kernel##_plain arguments)
#endif

/* Calls a kernel that has no text of its own for AVX-512. */
#if SFIELD__SIMD_SETS
#define SFIELD__CALL(kernel, simd, arguments) ((simd) ? kernel##_avx2 arguments : kernel##_plain arguments)
#else
#define SFIELD__CALL(kernel, simd, arguments) ((void)(simd), kernel##_plain arguments)
#endif

static void sfield__mix_samples(const sfield_field *f, const sfield__between *at, uint32_t n, float *out,
                                int simd)
{
    SFIELD__CALL_BEST(sfield__mix, simd, (f, at, n, out));
}

static void sfield__widen_samples(const sfield_field *f, const uint8_t *first, uint32_t n, float *out,
                                  int simd)
{
    SFIELD__CALL_BEST(sfield__widen, simd, (f, first, n, out));
}

static void sfield__rows_to_planes(const float *rows, size_t stride, uint32_t n, float *planes, int simd)
{
    SFIELD__CALL_BEST(sfield__transpose, simd, (rows, stride, n, planes));
}

/* Interpolates between eight samples, for the lanes by their factors, into planes; unless more is 0 the
   coefficients are added to what the planes hold. */
static void sfield__mix_eight(const sfield__eight *c, const sfield__place *at, const float *factor, int more,
                              float *out, int simd)
{
    SFIELD__CALL_BEST(sfield__eight_to_planes, simd, (c, at, factor, more, out));
}

/* Adds to sum each lane's dot product of t, in planes, with what lies between eight samples. */
static void sfield__dot_eight(const sfield__eight *c, const sfield__place *at, const float *factor,
                              const float *t, float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__eight_times, simd, (c, at, factor, t, sum));
}

/* Does what sfield__dot_eight does for lanes that each lie between samples of their own, in a frame of a
   source: n coefficients, a multiple of 8, from number `from` on. room: 32 n floats. */
static void sfield__dot_single(const sfield_field *f, const sfield__place *at, uint32_t frame,
                               const float *factor, uint32_t from, uint32_t n, const float *t, float *room,
                               float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__singles_times, simd, (f, at, frame, factor, from, n, t, room, sum));
}

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
    SFIELD__CALL_BEST(sfield__recall, simd, (value, scale, n, t));
}

#ifndef SFIELD_WITHOUT_BUILD
static void sfield__draw_triangles16(const sfield__build *b, sfield__view *v, const float *eye)
{
    SFIELD__CALL_BEST(sfield__draw_triangles, b->simd, (b, v, eye));
}

static void sfield__find_crossings16(const sfield__build *b, const float *eye, sfield__inside_ray *ray)
{
    SFIELD__CALL_BEST(sfield__find_crossings, b->simd, (b, eye, ray));
}
#endif

#ifndef SFIELD_WITHOUT_WAVELETS
static void sfield__haar_squares16(uint32_t squares, const float *c, float *up, float *out, int simd)
{
    SFIELD__CALL_BEST(sfield__haar_squares, simd, (squares, c, up, out));
}

/* Writes max(0, cos) x solid angle of each texel. texel: four planes of cells, directions and solid
   angles. */
static void sfield__fill_cosines16(const float *texel, uint32_t cells, const float *n, float *t, int simd)
{
    SFIELD__CALL_BEST(sfield__fill_cosines, simd, (texel, cells, n, t));
}

/* Writes the dot products of T with the three channels of a sky: for each channel eight sums, of every eighth
   texel. The last eight of 32 floats mean nothing. */
static void sfield__dot_sky16(const float *sky, const float *t, uint32_t cells, float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__dot_sky, simd, (sky, t, cells, sum));
}

/* Multiplies the texels of a face by 1 - the function that its coefficients are. marks: the squares that have
   wavelets, or squares with wavelets below them. */
static void sfield__darken16(const float *coefs, const uint8_t *marks, uint32_t side, float *t, int simd)
{
    SFIELD__CALL_BEST(sfield__darken, simd, (coefs, marks, side, t));
}
#endif
