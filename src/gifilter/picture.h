/* ---- picture: rows of floats, and which neighbours show the same surface ---- */

/* Each row of the picture is GIFILT__PLANES rows of floats, so that neighbours are compared in vectors:
   position, normal, colour, frames. A pixel that shows nothing has normal and frames 0. So has a margin right
   of each row, which is as wide as the longest step and serves the row after as its left margin: no kernel
   has to ask where the picture ends. */
enum { GIFILT__RGB = 6, GIFILT__FRAMES = 9, GIFILT__PLANES = 10, GIFILT__MARGIN = 32, GIFILT__TASK_ROWS = 8 };

struct gifilt_filter {
    gifilt_system system;
    float     *memory[2];
    float     *history;            /* the last frame, in one of them */
    float     *next;               /* this frame, in the other */
    size_t     spacing;            /* floats from one row of floats to the next */
    uint32_t   width, height;
    uint8_t   *wrong_rows;         /* not 0: the row has a normal that is not unit */
    int        has_matrix;
    float      matrix[16];         /* of the frame in history */
};

struct gifilt__filter_run;
typedef void (*gifilt__filter_row)(const struct gifilt__filter_run *r, size_t y);

typedef struct gifilt__filter_run {
    gifilt_filter            *filter;
    const gifilt_frame *frame;
    const gifilt_points      *points;
    const float           *in;     /* irradiance; then rows of three rows, in_row floats apart */
    float                 *out;    /* the same, or with packed three floats a pixel */
    size_t                 in_row, out_row;
    int                    packed, recalls;
    uint32_t               step, history;
    float                  limits[3];      /* cosine, 1 / (1 - cosine), slope^2 */
    gifilt__filter_row        accumulate, smooth, row;        /* row: one of them, which tasks are for */
} gifilt__filter_run;

/* Asks for planes of a row that is read soon: more rows are read side by side than processors foresee. */
GIFILT__INLINE void gifilt__fetch_ahead(const float *p, size_t spacing, size_t planes)
{
    size_t c;
    for (c = 0; c < planes; c++) GIFILT__PREFETCH(p + c * spacing);
}

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
