/* ---- wavelets: Haar transforms of cubes, and products of coefficients ---- */

/* Does what sfield__haar_level does for a multiple of four squares. */
static void sfield__haar_squares16(uint32_t squares, const float *c, float *up, float *out, int simd);

/* Writes a level's wavelets to out, and its squares' scaling coefficients to up. Morton order makes both a
   walk through memory. */
static void sfield__haar_level(uint32_t squares, const float *c, float *up, float *out)
{
    uint32_t i;
    for (i = 0; i < squares; i++) {
        float a = c[4 * i] + c[4 * i + 1], b = c[4 * i] - c[4 * i + 1], d = c[4 * i + 2] + c[4 * i + 3];
        float e = c[4 * i + 2] - c[4 * i + 3], *w = out + squares + 3 * i;
        w[0] = 0.5f * (b + e);
        w[1] = 0.5f * (a - d);
        w[2] = 0.5f * (b - e);
        up[i] = 0.5f * (a + d);
    }
}

/* Transforms one face. Every instruction set gives the same bits. */
static void sfield__haar_face(uint32_t side, const float *texels, float *out, int simd)
{
    float scaling[1365], *up = scaling;
    uint32_t squares;
    for (squares = side * side / 4; squares; up += squares, squares /= 4) {
        if (squares > 1) sfield__haar_squares16(squares, texels, up, out, simd);
        else sfield__haar_level(squares, texels, up, out);
        texels = up;
    }
    out[0] = texels[0];
}

static void sfield__haar_up(const float *w, uint32_t squares, const float *scaling, float *out)
{
    uint32_t i;
    for (i = squares; i-- > 0;) {               /* from the end, so that out may be scaling */
        float s = scaling[i], x = w[3 * i], y = w[3 * i + 1];
        float z = w[3 * i + 2], *c = out + 4 * i;
        c[0] = 0.5f * (s + x + y + z);
        c[1] = 0.5f * (s - x + y - z);
        c[2] = 0.5f * (s + x - y - z);
        c[3] = 0.5f * (s - x - y + z);
    }
}

static void sfield__haar_texels(uint32_t side, const float *coefs, float *texels)
{
    uint32_t face, squares, n = side * side;
    for (face = 0; face < 6; face++, coefs += n, texels += n) {
        texels[0] = coefs[0];
        for (squares = 1; squares < n; squares *= 4)
            sfield__haar_up(coefs + squares, squares, texels, texels);
    }
}

/* Transforms the six faces of a cube. The caller knows what the processor can do: to ask it for every cube
   costs several times as much as the transform under virtual machines. */
static void sfield__haar_cube(uint32_t side, const float *texels, float *coefs, int simd)
{
    uint32_t face, n = side * side;
    for (face = 0; face < 6; face++) sfield__haar_face(side, texels + face * n, coefs + face * n, simd);
}

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs)
{
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    sfield__haar_cube(side, texels, coefs, sfield__simd_level());
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels)
{
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    sfield__haar_texels(side, coefs, texels);
    return SFIELD_OK;
}

/* Marks are a byte for each square of a face, not 0 if the square or one below it has coefficients, level
   after level: number sfield__mark_base(n) + i is square i of a level of n squares. */
#define SFIELD__MARKS 1365u                     /* (4^6 - 1) / 3 squares a face of 64 x 64 */

static uint32_t sfield__mark_base(uint32_t squares) { return (squares - 1) / 3; }

static void sfield__mark_squares(uint32_t side, const float *coefs, uint8_t *marks)
{
    uint32_t squares, i;
    for (squares = side * side / 4; squares; squares /= 4)
        for (i = 0; i < squares; i++) {
            const float *w = coefs + squares + 3 * i;
            uint8_t used = w[0] != 0 || w[1] != 0 || w[2] != 0;
            if (squares < side * side / 4) {
                const uint8_t *below = marks + sfield__mark_base(4 * squares) + 4 * i;
                used = (uint8_t)(used | below[0] | below[1] | below[2] | below[3]);
            }
            marks[sfield__mark_base(squares) + i] = used;
        }
}

typedef struct sfield__trees {
    const float   *a, *b;
    float         *out;             /* of a face */
    const uint8_t *marks_a, *marks_b;
    uint32_t       leaves;          /* squares of the finest level that has wavelets */
} sfield__trees;

/* Writes the product where one operand is constant below: the other operand, scaled. */
static void sfield__scale_tree(const sfield__trees *t, const float *from, const uint8_t *marks, float factor,
                               uint32_t squares, uint32_t i)
{
    uint32_t k;
    if (!marks[sfield__mark_base(squares) + i]) return;
    for (k = 0; k < 3; k++) t->out[squares + 3 * i + k] = factor * from[squares + 3 * i + k];
    for (k = 0; k < 4 && squares < t->leaves; k++)
        sfield__scale_tree(t, from, marks, factor, 4 * squares, 4 * i + k);
}

/* Returns the mean of the product over square i of a level, given the means of both; writes its wavelets.
   Where both have detail the product is that of the quarters, put together again: every tripling coefficient
   of Ng et al. in one step. Depth at most 6. */
static float sfield__multiply_tree(const sfield__trees *t, float mean_a, float mean_b, uint32_t squares,
                                   uint32_t i, float side)
{
    uint32_t k, mark = sfield__mark_base(squares) + i;
    const float *a = t->a + squares + 3 * i, *b = t->b + squares + 3 * i;
    float *w = t->out + squares + 3 * i, c[4], scale = 1 / side;
    if (!t->marks_a[mark] || !t->marks_b[mark]) {
        if (t->marks_a[mark]) sfield__scale_tree(t, t->a, t->marks_a, mean_b, squares, i);
        if (t->marks_b[mark]) sfield__scale_tree(t, t->b, t->marks_b, mean_a, squares, i);
        return mean_a * mean_b;
    }
    for (k = 0; k < 4; k++) {
        float x = k & 1 ? -scale : scale, y = k & 2 ? -scale : scale, z = k == 0 || k == 3 ? scale : -scale;
        float p = mean_a + x * a[0] + y * a[1] + z * a[2], q = mean_b + x * b[0] + y * b[1] + z * b[2];
        c[k] =
            squares < t->leaves ? sfield__multiply_tree(t, p, q, 4 * squares, 4 * i + k, 0.5f * side) : p * q;
    }
    w[0] = 0.25f * side * (c[0] - c[1] + c[2] - c[3]);
    w[1] = 0.25f * side * (c[0] + c[1] - c[2] - c[3]);
    w[2] = 0.25f * side * (c[0] - c[1] - c[2] + c[3]);
    return 0.25f * (c[0] + c[1] + c[2] + c[3]);
}

static void sfield__haar_multiply(uint32_t side, const float *a, const float *b, float *out)
{
    uint8_t marks[2][SFIELD__MARKS];
    uint32_t face, n = side * side;
    sfield__trees t;
    memset(out, 0, 6 * n * sizeof *out);
    t.marks_a = marks[0];
    t.marks_b = marks[1];
    t.leaves = n / 4;
    for (face = 0; face < 6; face++) {
        t.a = a + face * n;
        t.b = b + face * n;
        t.out = out + face * n;
        sfield__mark_squares(side, t.a, marks[0]);
        sfield__mark_squares(side, t.b, marks[1]);
        t.out[0] = (float)side *
                   sfield__multiply_tree(&t, t.a[0] / (float)side, t.b[0] / (float)side, 1, 0, (float)side);
    }
}

SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out)
{
    if (!sfield__is_side(side, 2) || !a || !b || !out || out == a || out == b) return SFIELD_ERR_ARGUMENT;
    sfield__haar_multiply(side, a, b, out);
    return SFIELD_OK;
}
