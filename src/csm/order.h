/* ---- order: from cells to places in the sequence ---- */

/* A curve on its way through a grid: out receives the numbers of cells, count how many there are so far. */
typedef struct cohsm__walk { uint32_t *out, count, width; } cohsm__walk;

/* Returns v / 2, rounded down. */
static int cohsm__halve_down(int v) { return v >= 0 ? v / 2 : -((1 - v) / 2); }

static int cohsm__sign(int v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/* Walks a Hilbert-like curve through a rectangle of any size: the curve starts at (x, y) and covers the cells
   spanned by the vectors a (along which it ends up) and b. Long rectangles are cut in two along a; others in
   three, as Hilbert's square is in four with the middle two joined. Halves are made even where possible,
   which leaves at most one diagonal step. */
static void cohsm__hilbert_walk(cohsm__walk *walk, int x, int y, int ax, int ay, int bx, int by)
{
    int w = abs(ax + ay), h = abs(bx + by), i;
    int dax = cohsm__sign(ax), day = cohsm__sign(ay), dbx = cohsm__sign(bx), dby = cohsm__sign(by);
    int ax2 = cohsm__halve_down(ax), ay2 = cohsm__halve_down(ay);
    int bx2 = cohsm__halve_down(bx), by2 = cohsm__halve_down(by);

    if (h == 1 || w == 1) {
        for (i = 0; i < (h == 1 ? w : h); i++) {
            walk->out[walk->count++] = (uint32_t)x + (uint32_t)y * walk->width;
            x += h == 1 ? dax : dbx;
            y += h == 1 ? day : dby;
        }
        return;
    }
    if (2 * w > 3 * h) {
        if (abs(ax2 + ay2) % 2 && w > 2) {
            ax2 += dax;
            ay2 += day;
        }
        cohsm__hilbert_walk(walk, x, y, ax2, ay2, bx, by);
        cohsm__hilbert_walk(walk, x + ax2, y + ay2, ax - ax2, ay - ay2, bx, by);
        return;
    }
    if (abs(bx2 + by2) % 2 && h > 2) {
        bx2 += dbx;
        by2 += dby;
    }
    cohsm__hilbert_walk(walk, x, y, bx2, by2, ax2, ay2);
    cohsm__hilbert_walk(walk, x + bx2, y + by2, ax, ay, bx - bx2, by - by2);
    cohsm__hilbert_walk(walk, x + (ax - dax) + (bx2 - dbx), y + (ay - day) + (by2 - dby), -bx2, -by2,
                        -(ax - ax2), -(ay - ay2));
}

/* Writes into cells[i] the cell at place i. Zig-zag takes any size, and so does Hilbert in 1 and 2
   dimensions; in 3 dimensions Hilbert is the cube's curve for powers of two, else layers of the 2-D curve,
   every other one backwards. */
static void cohsm__order_cells(uint32_t *cells, const uint32_t *side, cohsm_order order)
{
    uint32_t n0 = side[0], n1 = side[1], n2 = side[2], n = n0 * n1 * n2;
    uint32_t i, x, y, z;
    uint32_t bits, c[3];
    cohsm__walk walk;

    if (order == COHSM_ORDER_HILBERT && n2 > 1 && n0 == n1 && n1 == n2 && (n0 & (n0 - 1u)) == 0) {
        for (bits = 0; 1u << bits < n0; bits++) {}
        for (i = 0; i < n; i++) {
            cohsm__hilbert_cell(i, bits, 3, c);
            cells[i] = c[0] + n0 * (c[1] + n1 * c[2]);
        }
        return;
    }
    if (order == COHSM_ORDER_HILBERT) {
        walk.out = cells;
        walk.count = 0;
        walk.width = n0;
        if (n0 >= n1) cohsm__hilbert_walk(&walk, 0, 0, (int)n0, 0, 0, (int)n1);
        else cohsm__hilbert_walk(&walk, 0, 0, 0, (int)n1, (int)n0, 0);
        for (z = 1; z < n2; z++)
            for (i = 0; i < n0 * n1; i++) cells[z * n0 * n1 + i] = cells[z * n0 * n1 - 1u - i] + n0 * n1;
        return;
    }
    for (i = 0; i < n; i++) {
        if (order == COHSM_ORDER_ZIGZAG_THETA) {
            y = i % n1;
            x = i / n1 % n0;
            z = i / (n0 * n1);
            if ((i / n1) & 1u) y = n1 - 1u - y;
            if (z & 1u) x = n0 - 1u - x;
        } else {
            x = i % n0;
            y = i / n0 % n1;
            z = i / (n0 * n1);
            if (order == COHSM_ORDER_ZIGZAG && (i / n0) & 1u) x = n0 - 1u - x;
            if (order == COHSM_ORDER_ZIGZAG && z & 1u) y = n1 - 1u - y;
        }
        cells[i] = x + n0 * (y + n1 * z);
    }
}
