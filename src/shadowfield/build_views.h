/* ---- building: what is seen of a mesh from a sample point ---- */

/* Sets the bits of samples x0 to x1 of a row. */
SFIELD__INLINE void sfield__set_bits(uint64_t *row, int x0, int x1)
{
    int a = x0 >> 6, b = x1 >> 6, w;
    uint64_t first = ~(uint64_t)0 << (x0 & 63), last = ~(uint64_t)0 >> (63 - (x1 & 63));
    if (a == b) row[a] |= first & last;
    else {
        row[a] |= first;
        for (w = a + 1; w < b; w++) row[w] = ~(uint64_t)0;
        row[b] |= last;
    }
}

/* Draws the samples x0 to x1 of a row that are nearer than what was drawn before; of equally near ones the
   triangle that comes first in the mesh is kept, whatever is drawn first. plane: four floats, 16 apart, see
   sfield__store_planes; owner: the triangle + 1, and the topmost bit for the side that does not emit. */
static void sfield__draw_span(sfield__view *v, size_t row, int x0, int x1, const float *plane, uint32_t owner)
{
    const float half = 0.5f * (float)v->width, t = ((float)(row & (v->width - 1)) + 0.5f) / half - 1;
    float *depth = v->depth + row * v->width;
    uint32_t *drawn = v->owner + row * v->width;
    int x;
    for (x = x0; x <= x1; x++) {
        float close = (plane[0] * (((float)x + 0.5f) / half - 1) + plane[16] * t + plane[32]) / plane[48];
        if (close > depth[x] ||
            (close == depth[x] && (owner & 0x7fffffffu) < (drawn[x] & 0x7fffffffu))) {
            depth[x] = close;
            drawn[x] = owner;
        }
    }
}

/* Draws the samples x0 to x1 of a row as sfield__draw_span or sfield__set_bits does, but for those in holes
   of the mesh's mask. corners: of the triangle, nine floats, 16 apart: x, y and depth of each on the face. */
static void sfield__draw_masked_span(const sfield__build *b, sfield__view *v, size_t row, int x0, int x1,
                                     const float *plane, uint32_t owner, const float *corners)
{
    const double half = 0.5 * (double)v->width;
    const double t = ((double)(row & (v->width - 1)) + 0.5) / half - 1;
    double c[9];
    float weights[3];
    int x;
    for (x = 0; x < 9; x++) c[x] = (double)corners[16 * x];
    for (x = x0; x <= x1; x++) {
        sfield__mask_weights(c, ((double)x + 0.5) / half - 1, t, weights);
        if (!b->mask_fn(b->mask_user, (owner & 0x7fffffffu) - 1, weights)) continue;
        if (v->depth) sfield__draw_span(v, row, x, x, plane, owner);
        else sfield__set_bits(v->bits + row * (v->width / 64), x, x);
    }
}

/* Draws all triangles of the mesh that an eye sees, sixteen at a time, in any order. */
static void sfield__draw_triangles16(const sfield__build *b, sfield__view *v, const float *eye);

/* Counts the samples of texels in a column of s words, of which each holds a row of 64 / s texels. Neighbours
   are counted apart, so that each sum has the room of two texels. */
static void sfield__count_column(const uint64_t *row, size_t words, uint32_t s, uint32_t *count)
{
    const uint64_t ones = 0x5555555555555555u, twos = 0x3333333333333333u, fours = 0x0f0f0f0f0f0f0f0fu;
    const uint64_t keep = s == 1 ? ones : s == 2 ? twos : s == 4 ? fours : 0x00ff00ff00ff00ffu;
    const uint32_t field = s < 8 ? s : 8;
    uint64_t even = 0, odd = 0;
    uint32_t k;
    for (k = 0; k < s; k++, row += words) {
        uint64_t x = *row;
        if (s > 1) x -= x >> 1 & ones;
        if (s > 2) x = (x & twos) + (x >> 2 & twos);
        if (s > 4) x = (x + (x >> 4)) & fours;
        even += x & keep;
        odd += x >> field & keep;
    }
    if (s <= 8) {
        for (k = 0; k < 64 / s; k += 2) {
            count[k] = (uint32_t)(even >> k * s & (((uint64_t)1 << 2 * s) - 1));
            count[k + 1] = (uint32_t)(odd >> k * s & (((uint64_t)1 << 2 * s) - 1));
        }
        return;
    }
    even += odd;
    for (k = 16; k < s; k *= 2) even += even >> k;
    for (k = 0; k < 64 / s; k++) count[k] = (uint32_t)(even >> k * s & 0xffffu);
}

/* Adds the bits of a row of texels up, and clears them. */
static void sfield__count_bits(const sfield__build *b, sfield__view *v, uint32_t face, uint32_t y)
{
    const uint32_t n = b->h.cube_side, s = v->scale, words = v->width / 64;
    const float share = 1 / (float)(s * s);         /* a power of two */
    uint64_t *row = v->bits + (size_t)(face * v->width + y * s) * words;
    float *texel = v->texel + sfield__texel_number(n, face, 0, y);
    uint32_t w, k, at = 0, count[64];
    for (w = 0; w < words; w++) {
        sfield__count_column(row + w, words, s, count);
        for (k = 0; k < 64 / s; k++) {
            texel[at] = (float)count[k] * share;
            at = (at - 0x555u) & 0x555u;            /* the next one along x, in Morton order */
        }
    }
    memset(row, 0, (size_t)s * words * sizeof *row);
}

/* Adds the radiance seen in a row of samples to texels, and clears the row. */
static void sfield__count_radiance(const sfield__build *b, sfield__view *v, uint32_t face, uint32_t y)
{
    const uint32_t n = b->h.cube_side, s = v->scale;
    const size_t row = (size_t)(face * v->width + y) * v->width;
    const float share = 1 / (float)(s * s);
    uint32_t x, c;
    for (x = 0; x < v->width; x++) {
        const uint32_t owner = v->owner[row + x];
        if (!owner) continue;
        if (owner >> 31 == 0) {
            float *texel = v->texel + sfield__texel_number(n, face, x / s, y / s);
            const float *radiance = b->radiance + 3 * (size_t)(owner - 1);
            for (c = 0; c < 3; c++) texel[c * b->cells] += radiance[c] * share;
        }
        v->depth[row + x] = 0;
        v->owner[row + x] = 0;
    }
}

/* Adds the drawn samples up to texels, and clears the buffers. */
static void sfield__count_samples(const sfield__build *b, sfield__view *v)
{
    const uint32_t n = b->h.cube_side, s = v->scale;
    uint32_t face, y, k;
    for (face = 0; face < 6; face++)
        for (y = 0; y < n; y++) {
            uint8_t *touched = v->touched + face * v->width + y * s;
            if (!memchr(touched, 1, s)) continue;
            for (k = 0; k < s && v->depth; k++)
                if (touched[k]) sfield__count_radiance(b, v, face, y * s + k);
            if (!v->depth) sfield__count_bits(b, v, face, y);
            memset(touched, 0, s);
        }
}

/* Fills the texels of one sample: alpha, or three channels of radiance. */
static void sfield__view_from(const sfield__build *b, sfield__view *v, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->what == SFIELD__EMISSIVE ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, c;
    memset(v->texel, 0, (size_t)b->h.channels * b->cells * sizeof *v->texel);
    /* A word of 64 bits holds a row of a texel's samples. */
    if (most > 64 * b->h.cube_side) most = 64 * b->h.cube_side;
    for (v->width = 64; v->width < most && ((float)v->width < 24 * d || v->width < 2 * b->h.cube_side);)
        v->width *= 2;
    if (b->what == SFIELD__SELF) v->width = b->h.cube_side < 32 ? 64 : 2 * b->h.cube_side;
    v->scale = v->width / b->h.cube_side;
    if (b->what == SFIELD__ANALYTIC || b->what == SFIELD__CALLBACK) {
        sfield__sample_cube(b, v, eye);
        for (c = 0; c < b->cells && b->what == SFIELD__CALLBACK; c++)
            v->texel[c] = v->texel[c] < 1 ? v->texel[c] : 1;
        return;
    }
    sfield__draw_triangles16(b, v, eye);
    sfield__count_samples(b, v);
}
