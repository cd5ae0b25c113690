/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* A distribution over cells. sums[i] is the sum of the weights before cell i and sums[count] that of all;
   the array is the caller's. Sums are double, since a float sum of 1e6 small weights is wrong in the third
   digit. */
typedef struct P_cdf { const double *sums; uint32_t count; } P_cdf;

typedef struct P_cdf_sample {
    uint32_t index;
    float    fraction;      /* where u fell inside the cell, [0, 1): a fresh random number */
    float    probability;   /* of the cell; 0 only if all weights are 0 */
} P_cdf_sample;

/* Returns how many doubles a distribution over count cells needs; 0 if their size overflows. */
static inline size_t P_cdf_doubles(size_t count)
{
    return count < SIZE_MAX / sizeof(double) ? count + 1u : 0u;
}

/* Makes a distribution of weights, each times `scale`, which is 1 for most callers. Negative, NaN and
   infinite weights count as 0; their number is returned. */
static inline size_t P_cdf_build(P_cdf *cdf, double *sums, const float *weights, uint32_t count, double scale)
{
    size_t bad = 0;
    double sum = 0.0;
    uint32_t i;

    for (i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, weights + i, sizeof bits);
        sums[i] = sum;
        if ((bits & 0x7fffffffu) == 0) continue;
        if ((bits & 0x7f800000u) == 0x7f800000u || bits >> 31) bad++;
        else sum += (double)weights[i] * scale;
    }
    sums[count] = sum;
    cdf->sums = sums;
    cdf->count = count;
    return bad;
}

static inline double P_cdf_total(const P_cdf *cdf) { return cdf->sums[cdf->count]; }

static inline float P_cdf_probability(const P_cdf *cdf, uint32_t index)
{
    double total = P_cdf_total(cdf);
    return total > 0.0 ? (float)((cdf->sums[index + 1u] - cdf->sums[index]) / total) : 0.0f;
}

/* Returns the cell i with sums[i] <= u * total < sums[i + 1]. The strict upper bound keeps empty cells out,
   even at u = 0, and keeps the index in range for u below 1. u outside [0, 1) is clamped. */
static inline P_cdf_sample P_cdf_sample_at(const P_cdf *cdf, float u)
{
    P_cdf_sample s;
    double total = P_cdf_total(cdf), x, width, f;
    uint32_t lo = 0, hi = cdf->count;

    s.index = 0;
    s.fraction = 0.0f;
    s.probability = 0.0f;
    if (!(total > 0.0)) return s;
    if (!(u > 0.0f)) u = 0.0f;
    if (u > 0.99999994f) u = 0.99999994f;
    x = (double)u * total;
    while (hi - lo > 1u) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (cdf->sums[mid] <= x) lo = mid;
        else hi = mid;
    }
    /* This happens only if x was rounded up to a total of denormal size. */
    while (lo > 0 && !(cdf->sums[lo + 1u] > cdf->sums[lo])) lo--;
    width = cdf->sums[lo + 1u] - cdf->sums[lo];
    f = (x - cdf->sums[lo]) / width;
    s.index = lo;
    s.fraction = f < 0.99999994 ? (float)f : 0.99999994f;
    s.probability = (float)(width / total);
    return s;
}

/* A distribution over the cells of a grid: `rows` is the one over whole rows, `sums` has that of each row. */
typedef struct P_cdf2 { const double *rows, *sums; uint32_t width, height; } P_cdf2;

typedef struct P_cdf2_sample {
    uint32_t x, y;
    float    fx, fy;        /* inside the cell, [0, 1) */
    float    probability;   /* of the cell */
} P_cdf2_sample;

/* Returns how many doubles a distribution over width * height cells needs; 0 if their size overflows. */
static inline size_t P_cdf2_doubles(uint32_t width, uint32_t height)
{
    size_t row = (size_t)width + 1u, rows = (size_t)height + 1u;
    if (row == 0 || rows == 0 || height > (SIZE_MAX / sizeof(double) - rows) / row) return 0;
    return row * height + rows;
}

/* Makes a distribution of weights that are given row by row. row_scale, NULL for 1, multiplies whole rows,
   as the solid angle of the rows of a latitude-longitude map does. Returns the number of bad weights, as
   P_cdf_build. */
static inline size_t P_cdf2_build(P_cdf2 *cdf, double *memory, const float *weights, const float *row_scale,
                                  uint32_t width, uint32_t height)
{
    double *rows = memory, *sums = memory + height + 1u, total = 0.0;
    size_t bad = 0;
    uint32_t y;

    for (y = 0; y < height; y++) {
        P_cdf row;
        bad += P_cdf_build(&row, sums + (size_t)y * (width + 1u), weights + (size_t)y * width, width,
                           row_scale ? (double)row_scale[y] : 1.0);
        rows[y] = total;
        total += P_cdf_total(&row);
    }
    rows[height] = total;
    cdf->rows = rows;
    cdf->sums = sums;
    cdf->width = width;
    cdf->height = height;
    return bad;
}

static inline P_cdf P_cdf2_row(const P_cdf2 *cdf, uint32_t y)
{
    P_cdf row;
    row.sums = cdf->sums + (size_t)y * (cdf->width + 1u);
    row.count = cdf->width;
    return row;
}

static inline double P_cdf2_total(const P_cdf2 *cdf) { return cdf->rows[cdf->height]; }

static inline float P_cdf2_probability(const P_cdf2 *cdf, uint32_t x, uint32_t y)
{
    const double *row = cdf->sums + (size_t)y * (cdf->width + 1u);
    double total = P_cdf2_total(cdf);
    return total > 0.0 ? (float)((row[x + 1u] - row[x]) / total) : 0.0f;
}

static inline P_cdf2_sample P_cdf2_sample_at(const P_cdf2 *cdf, float u, float v)
{
    P_cdf marginal, row;
    P_cdf_sample sx, sy;
    P_cdf2_sample s;

    marginal.sums = cdf->rows;
    marginal.count = cdf->height;
    sy = P_cdf_sample_at(&marginal, v);
    row = P_cdf2_row(cdf, sy.index);
    sx = P_cdf_sample_at(&row, u);
    s.x = sx.index;
    s.y = sy.index;
    s.fx = sx.fraction;
    s.fy = sy.fraction;
    s.probability = P_cdf2_probability(cdf, s.x, s.y);
    return s;
}
