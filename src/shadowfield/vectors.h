/* ---- vectors: sixteen floats at a time ---- */

#if defined(__GNUC__) || defined(__clang__)
#define SFIELD__INLINE static inline __attribute__((always_inline))
#else
#define SFIELD__INLINE static inline
#endif

enum {
    SFIELD__LANES = 16,             /* points that are treated at a time */
    SFIELD__STAGED = 300,           /* pairs of coefficients of 5 bands, which a stack holds */
    SFIELD__STAGED_COEFS = 25,      /* coefficients of 5 bands */
    SFIELD__PIECES = 16,            /* tasks that a call is divided into */
    SFIELD__SHARED = 3              /* lanes that the same eight samples must serve, on average */
};

/* The functions below call the kernels of the best instruction set there is, which kernels_end.h chooses. All
   of them work on sixteen lanes. */

/* Writes the product a b, or a - a b if occlude is not 0. */
static void sfield__product16(const sfield_algebra *t, const float *a, const float *b, float *out,
                              size_t stride, int occlude);

static void sfield__rotate16(const sfield_rotation *r, const float *in, float *out, size_t stride,
                             int inverse, int simd);
