/* ---- kernels: wavelets of one point, sixteen texels at a time ---- */

/* See sfield__haar_squares16. A square is four lanes, and two steps of sums and differences of neighbours
   make of its texels the scaling coefficient and the three wavelets, in the order in which they are
   stored. Squares are taken from the last to the first: the scaling coefficient falls on the wavelet
   before, which is written next. */
SFIELD__KERNEL static void sfield__haar_squares(uint32_t squares, const float *c, float *up, float *out)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes odd = sfield__lanes_select(sfield__mask_of_bits(0xaaaau), minus, one);
    const sfield__lanes high = sfield__lanes_select(sfield__mask_of_bits(0xccccu), minus, one);
    const sfield__lanes half = sfield__lanes_all(0.5f);
    float four[16];
    uint32_t i, k;
    for (i = squares; i > 0; i -= 4) {
        sfield__lanes x = sfield__lanes_load(c + 4 * (size_t)i - 16);
        x = sfield__lanes_muladd(x, odd, sfield__lanes_swap_ones(x));
        x = sfield__lanes_mul(half, sfield__lanes_muladd(x, high, sfield__lanes_swap_twos(x)));
        sfield__lanes_store(four, x);
        for (k = 4; k > 0; k--) {
            float *to = out + squares + 3 * (size_t)(i + k - 5) - 1;
            memcpy(to, four + 4 * k - 4, 4 * sizeof *four);
            up[i + k - 5] = four[4 * k - 4];
        }
    }
}

/* See sfield__fill_cosines16. */
SFIELD__KERNEL static void sfield__fill_cosines(const float *texel, uint32_t cells, const float *n, float *t)
{
    const sfield__lanes a = sfield__lanes_all(n[0]), b = sfield__lanes_all(n[1]), c = sfield__lanes_all(n[2]);
    const float *end = texel + cells;
    for (; texel < end; texel += 16, t += 16) {
        sfield__lanes d = sfield__lanes_mul(a, sfield__lanes_load(texel));
        d = sfield__lanes_add(d, sfield__lanes_mul(b, sfield__lanes_load(texel + cells)));
        d = sfield__lanes_add(d, sfield__lanes_mul(c, sfield__lanes_load(texel + 2 * (size_t)cells)));
        d = sfield__lanes_max(d, sfield__lanes_all(0));
        sfield__lanes_store(t, sfield__lanes_mul(d, sfield__lanes_load(texel + 3 * (size_t)cells)));
    }
}

/* See sfield__dot_sky16. Two channels share the lanes. */
SFIELD__KERNEL static void sfield__dot_sky(const float *sky, const float *t, uint32_t cells, float *sum)
{
    const float *end = t + cells;
    sfield__lanes a = sfield__lanes_all(0), b = a;
    for (; t < end; t += 8, sky += 8) {
        const float *blue = sky + 2 * (size_t)cells;
        const sfield__lanes x = sfield__lanes_load_halves(t, t);
        a = sfield__lanes_muladd(x, sfield__lanes_load_halves(sky, sky + cells), a);
        b = sfield__lanes_muladd(x, sfield__lanes_load_halves(blue, blue), b);
    }
    sfield__lanes_store(sum, a);
    sfield__lanes_store(sum + 16, b);
}

/* Multiplies n texels, a multiple of 16, by 1 - mean. */
SFIELD__KERNEL static void sfield__dim_texels(float *t, uint32_t n, float mean)
{
    const sfield__lanes keep = sfield__lanes_all(1 - mean);
    const float *end = t + n;
    for (; t < end; t += 16) sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), keep));
}

/* Multiplies the sixteen texels of four squares of the finest level by 1 - the function there. w: the
   wavelets of the squares, 0 where they have none; mean: the means of the squares. */
static inline SFIELD__IN_KERNEL void sfield__shade_fours(const float *w, const float *mean, float scale,
                                                         float *t)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes by = sfield__lanes_all(scale);
    const sfield__lanes x = sfield__lanes_select(sfield__mask_of_bits(0xaaaau), minus, one);
    const sfield__lanes y = sfield__lanes_select(sfield__mask_of_bits(0xccccu), minus, one);
    const sfield__lanes z = sfield__lanes_mul(x, y);
    sfield__lanes m = sfield__lanes_load_fours(mean, 1);
    m = sfield__lanes_muladd(x, sfield__lanes_mul(by, sfield__lanes_load_fours(w, 3)), m);
    m = sfield__lanes_muladd(y, sfield__lanes_mul(by, sfield__lanes_load_fours(w + 1, 3)), m);
    m = sfield__lanes_muladd(z, sfield__lanes_mul(by, sfield__lanes_load_fours(w + 2, 3)), m);
    sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), sfield__lanes_sub(one, m)));
}

/* Multiplies the texels of square i of a level by 1 - the function below the square, which is marked.
   leaves: the squares of the finest level; scale: 1 / side of the texels of a face, times the level's
   squares along a side. */
SFIELD__KERNEL static void sfield__shade_square(const float *coefs, const uint8_t *marks, uint32_t leaves,
                                                float mean, uint32_t squares, uint32_t i, float scale,
                                                float *t)
{
    const float *w = coefs + squares + 3 * (size_t)i;
    const uint8_t *below = marks + (4 * squares - 1) / 3 + 4 * i;
    const uint32_t n = leaves / squares;
    const float x = scale * w[0], y = scale * w[1], z = scale * w[2];
    float m[4];
    uint32_t k;
    m[0] = mean + x + y + z;
    m[1] = mean - x + y - z;
    m[2] = mean + x - y - z;
    m[3] = mean - x - y + z;
    if (n == 4) {
        sfield__shade_fours(coefs + 4 * squares + 12 * (size_t)i, m, 2 * scale, t + 16 * (size_t)i);
        return;
    }
    for (k = 0; k < 4; k++) {
        const uint32_t quarter = 4 * i + k;
        if (below[k]) sfield__shade_square(coefs, marks, leaves, m[k], 4 * squares, quarter, 2 * scale, t);
        else if (m[k] != 0) sfield__dim_texels(t + (size_t)quarter * n, n, m[k]);
    }
}

/* See sfield__darken16. */
SFIELD__KERNEL static void sfield__darken(const float *coefs, const uint8_t *marks, uint32_t side, float *t)
{
    const float scale = 1 / (float)side, mean = coefs[0] / (float)side;
    if (marks[0]) sfield__shade_square(coefs, marks, side * side / 4, mean, 1, 0, scale, t);
    else if (mean != 0) sfield__dim_texels(t, side * side, mean);
}
