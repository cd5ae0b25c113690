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
