/* ---- chunk: some pixels of a row ---- */

/* What this frame sees of a chunk of pixels, and what the last one knew of them. */
typedef struct gifilt__chunk {
    float now[GIFILT__PLANES][GIFILT__SPAN];
    float given[9][GIFILT__SPAN + 1];   /* places, normals, light; also the place of the pixel after: after
                                           the last one of a row that of the pixel before */
    float size2[GIFILT__SPAN];          /* square of the distance within which a pixel of the last frame may
                                           show the same surface */
    float x[GIFILT__SPAN], y[GIFILT__SPAN];    /* where they were in the last frame's picture */
    float i[GIFILT__SPAN], j[GIFILT__SPAN];    /* whole numbers: the place lies between pixels i, j and i + 1,
                                                  j + 1 */
    float u[GIFILT__SPAN], v[GIFILT__SPAN];    /* how far between them, 0..1 */
    float there[GIFILT__SPAN];          /* 1 if the pixel shows something; after the projection, if the last
                                           frame may have seen it; otherwise 0 */
    float sums[5][GIFILT__SPAN];        /* over pixels of the last frame: colour, frames, weights */
} gifilt__chunk;

/* How many floats away a neighbour's shape and colour are, and its weight in the kernel. */
typedef struct gifilt__tap { ptrdiff_t shape, rgb; float weight; } gifilt__tap;

/* Lists the neighbours that row y's pixels have in the picture, up to eight, and returns how many they are.
   */
static inline size_t gifilt__taps(const gifilt__filter_run *r, size_t y, gifilt__tap taps[8])
{
    ptrdiff_t i, j, row = (ptrdiff_t)y, step = (ptrdiff_t)r->step;
    size_t count = 0;
    for (j = -step; j <= step; j += step)
        for (i = -step; i <= step; i += step) {
            if ((i == 0 && j == 0) || row + j < 0 || row + j >= (ptrdiff_t)r->filter->height) continue;
            taps[count].shape = j * (ptrdiff_t)(GIFILT__PLANES * r->filter->spacing) + i;
            taps[count].rgb = j * (ptrdiff_t)r->in_row + i;
            taps[count++].weight = i && j ? 1.0f : 2.0f;
        }
    return count;
}

/* Copies count pixels into a chunk; strides are in floats. */
GIFILT__INLINE void gifilt__chunk_read(gifilt__chunk *k, const float *p, size_t ps, const float *n, size_t ns,
                                 const float *light, size_t count)
{
    size_t l;
    for (l = 0; l < count; l++) {
        k->given[0][l] = p[ps * l];
        k->given[1][l] = p[ps * l + 1];
        k->given[2][l] = p[ps * l + 2];
    }
    for (l = 0; l < count; l++) {
        k->given[3][l] = n[ns * l];
        k->given[4][l] = n[ns * l + 1];
        k->given[5][l] = n[ns * l + 2];
    }
    for (l = 0; l < count; l++) {
        k->given[6][l] = light[3 * l];
        k->given[7][l] = light[3 * l + 1];
        k->given[8][l] = light[3 * l + 2];
    }
}
