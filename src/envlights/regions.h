/* ---- regions: median cut, minimum variance and inversion, all by summed-area tables ---- */

/* The sum over some texels of w = luminance x solid angle, and the sum of w times the texel's direction. */
typedef struct envlt__moments { double w, x, y, z; } envlt__moments;

typedef struct envlt__region {
    uint32_t face;
    uint32_t x0, y0, x1, y1;
    uint32_t lights;                /* of median cut: how many lights the region is to become */
    uint32_t cut_x, cut_y;          /* of variance: the column or row of the best cut; both 0: there is none
                                       */
    double   gain, rank;            /* the scatter that the cut takes away; the region of highest rank is cut
                                       first */
    envlt__moments sum;
} envlt__region;

/* Fills the summed-area table of (width + 1) x (height + 1) entries a face. Entry (x, y) holds the sum over
   all texels of the face with a lower column than x and a lower row than y. */
static void envlt__fill_table(const envlt__grid *g, envlt__moments *table)
{
    uint32_t f, x, y;
    size_t t = 0, stride = (size_t)g->width + 1;
    for (f = 0; f < g->faces; f++, table += stride * ((size_t)g->height + 1)) {
        memset(table, 0, stride * sizeof *table);
        for (y = 0; y < g->height; y++) {
            const envlt__moments *above = table + y * stride;
            envlt__moments *here = table + (y + 1) * stride, row = { 0, 0, 0, 0 };
            here[0] = row;
            for (x = 0; x < g->width; x++, t++) {
                double w = envlt__texel_weight(g, t);
                row.w += w;
                row.x += w * (double)g->dx[t];
                row.y += w * (double)g->dy[t];
                row.z += w * (double)g->dz[t];
                here[x + 1].w = above[x + 1].w + row.w;
                here[x + 1].x = above[x + 1].x + row.x;
                here[x + 1].y = above[x + 1].y + row.y;
                here[x + 1].z = above[x + 1].z + row.z;
            }
        }
    }
}

/* Fills a table of the energy alone. Median cut and inversion need no directions, and they are faster with a
   quarter of the memory. */
static void envlt__fill_energy(const envlt__grid *g, double *table)
{
    uint32_t f, x, y;
    size_t t = 0, stride = (size_t)g->width + 1;
    for (f = 0; f < g->faces; f++, table += stride * ((size_t)g->height + 1)) {
        memset(table, 0, stride * sizeof *table);
        for (y = 0; y < g->height; y++) {
            const double *above = table + y * stride;
            double *here = table + (y + 1) * stride, row = 0.0;
            here[0] = row;
            for (x = 0; x < g->width; x++, t++) {
                row += envlt__texel_weight(g, t);
                here[x + 1] = above[x + 1] + row;
            }
        }
    }
}

/* Returns the energy of the columns x0..x1 and rows y0..y1, ends excluded, of the region's face. */
static double envlt__area_energy(const envlt__grid *g, const double *table, const envlt__region *r,
                                 uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const double *top = table + stride * ((size_t)g->height + 1) * r->face + y0 * stride;
    const double *bottom = top + (y1 - y0) * stride;
    return (bottom[x1] - top[x1]) - (bottom[x0] - top[x0]);
}

/* Returns the moments of the columns x0..x1 and rows y0..y1, ends excluded, of the region's face. */
static envlt__moments envlt__area_moments(const envlt__grid *g, const envlt__moments *table,
                                          const envlt__region *r, uint32_t x0, uint32_t y0, uint32_t x1,
                                          uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const envlt__moments *t = table + stride * ((size_t)g->height + 1) * r->face;
    const envlt__moments *a = t + y0 * stride + x0, *b = t + y0 * stride + x1;
    const envlt__moments *c = t + y1 * stride + x0, *d = t + y1 * stride + x1;
    envlt__moments m;
    m.w = (d->w - b->w) - (c->w - a->w);
    m.x = (d->x - b->x) - (c->x - a->x);
    m.y = (d->y - b->y) - (c->y - a->y);
    m.z = (d->z - b->z) - (c->z - a->z);
    return m;
}

/* Returns the sum of w |d - mean|^2, which is w - |sum of w d|^2 / w, since directions have length 1. */
static double envlt__squared_spread(const envlt__moments *m)
{
    double s = m->w > 0.0 ? m->w - (m->x * m->x + m->y * m->y + m->z * m->z) / m->w : 0.0;
    return s > 0.0 ? s : 0.0;
}

/* Takes a cut for the region's best if it takes more scatter away than the best so far. `left` are the
   moments of one half, `whole` is the scatter of the region, `least` the energy that each half must exceed.
   */
static void envlt__try_cut(envlt__region *r, const envlt__moments *left, double whole, double least,
                           uint32_t x, uint32_t y)
{
    envlt__moments right;
    double gain;
    right.w = r->sum.w - left->w;
    right.x = r->sum.x - left->x;
    right.y = r->sum.y - left->y;
    right.z = r->sum.z - left->z;
    if (!(left->w > least) || !(right.w > least)) return;         /* no cut may make an empty half */
    gain = whole - envlt__squared_spread(left) - envlt__squared_spread(&right);
    if (gain <= r->gain) return;
    r->gain = gain;
    r->cut_x = x;
    r->cut_y = y;
}

/* Finds the cut of a region that leaves the least scatter: Viriyothai and Debevec, "Variance minimization
   light probe sampling", 2009. Which region is cut next is our own choice, since by gain alone a sun is never
   cut (docs/envlights.md). The rank is w^3 gain; its fourth root is w (gain / w)^(1/4), the importance of
   Agarwal et al. with the gain per energy in place of the solid angle. */
static void envlt__best_cut(const envlt__grid *g, const envlt__moments *table, envlt__region *r)
{
    double whole, least;
    uint32_t i;
    r->sum = envlt__area_moments(g, table, r, r->x0, r->y0, r->x1, r->y1);
    r->gain = -1.0;
    r->cut_x = r->cut_y = 0;
    whole = envlt__squared_spread(&r->sum);
    least = 1e-12 * r->sum.w;
    for (i = r->x0 + 1; i < r->x1; i++) {
        envlt__moments left = envlt__area_moments(g, table, r, r->x0, r->y0, i, r->y1);
        envlt__try_cut(r, &left, whole, least, i, 0);
    }
    for (i = r->y0 + 1; i < r->y1; i++) {
        envlt__moments left = envlt__area_moments(g, table, r, r->x0, r->y0, r->x1, i);
        envlt__try_cut(r, &left, whole, least, 0, i);
    }
    r->rank = r->cut_x | r->cut_y ? r->gain * r->sum.w * r->sum.w * r->sum.w : -1.0;
}

/* Cuts region a where it is best cut, and makes b of the far half. */
static void envlt__cut_region(envlt__region *a, envlt__region *b)
{
    *b = *a;
    if (a->cut_x) a->x1 = b->x0 = a->cut_x;
    else a->y1 = b->y0 = a->cut_y;
}

/* Cuts n regions into k, as far as cuts are found, and returns how many there are then. */
static uint32_t envlt__run_variance(const envlt__grid *g, const envlt__moments *table, envlt__region *r,
                                    uint32_t n, uint32_t k)
{
    uint32_t i;
    for (i = 0; i < n; i++) envlt__best_cut(g, table, &r[i]);
    while (n < k) {
        uint32_t best = 0;
        for (i = 1; i < n; i++)
            if (r[i].rank > r[best].rank) best = i;
        if (!(r[best].cut_x | r[best].cut_y)) break;
        envlt__cut_region(&r[best], &r[n]);
        envlt__best_cut(g, table, &r[best]);
        envlt__best_cut(g, table, &r[n++]);
    }
    return n;
}

/* Returns the column in which the energy from the region's left edge passes the target, and writes to *nearer
   which edge of that column comes closer to the target. Without along_x it does so for rows from the top. */
static uint32_t envlt__locate_energy(const envlt__grid *g, const double *table, const envlt__region *r,
                                     int along_x, double target, uint32_t *nearer)
{
    uint32_t lo = along_x ? r->x0 : r->y0, hi = along_x ? r->x1 : r->y1;
    double a = 0.0, b = r->sum.w;
    while (hi - lo > 1) {
        uint32_t mid = lo + (hi - lo) / 2;
        double w = along_x ? envlt__area_energy(g, table, r, r->x0, r->y0, mid, r->y1)
                           : envlt__area_energy(g, table, r, r->x0, r->y0, r->x1, mid);
        if (w <= target) {
            lo = mid;
            a = w;
        } else {
            hi = mid;
            b = w;
        }
    }
    *nearer = target - a <= b - target ? lo : hi;
    return lo;
}

/* Returns the line inside the region at which the energy comes nearest to the target. The region must have
   two columns (with along_x) or two rows at least. */
static uint32_t envlt__find_cut(const envlt__grid *g, const double *table, const envlt__region *r,
                                int along_x, double target)
{
    uint32_t begin = along_x ? r->x0 : r->y0, end = along_x ? r->x1 : r->y1, line;
    envlt__locate_energy(g, table, r, along_x, target, &line);
    return line <= begin ? begin + 1 : line >= end ? end - 1 : line;
}

/* Shares the lights out among the faces by energy. A face with any energy gets at least one light. */
static void envlt__share_faces(const envlt__grid *g, const double *table, envlt__region *r, uint32_t k)
{
    uint32_t f, given = 0, lit = 0;
    double before = 0.0, total = 0.0;
    for (f = 0; f < g->faces; f++) {
        r[f].sum.w = envlt__area_energy(g, table, &r[f], 0, 0, g->width, g->height);
        lit += r[f].sum.w > 0.0;
        total += r[f].sum.w;
    }
    for (f = 0; f < g->faces; f++) {
        uint32_t until;
        before += r[f].sum.w;
        /* before is summed as total was, so that after the last lit face this is exactly k - lit. */
        until = (uint32_t)((double)(k - lit) * (total > 0.0 ? before / total : 0.0) + 0.5);
        r[f].lights = r[f].sum.w > 0.0 ? until - given + 1 : 0;
        given = r[f].sum.w > 0.0 ? until : given;
    }
}

/* Cuts regions by Debevec, "A median cut algorithm for light probe sampling", 2005, for any k: a region that
   is to become n lights is cut across its longer side into shares of n / 2 and n - n / 2. Returns how many
   regions there are then. */
static uint32_t envlt__run_median(const envlt__grid *g, const double *table, envlt__region *r, uint32_t n,
                                  uint32_t k)
{
    uint32_t i;
    envlt__share_faces(g, table, r, k);
    for (i = 0; i < n;) {
        uint32_t w = r[i].x1 - r[i].x0, h = r[i].y1 - r[i].y0, half = r[i].lights / 2, m;
        double s = 1.0, c, wide, high = h;
        int along_x;
        if (r[i].lights < 2 || (w < 2 && h < 2)) {
            i++;
            continue;
        }
        if (g->faces == 1) envlt__sincos64(ENVLT__PI * (r[i].y0 + 0.5 * h) / g->height, &s, &c);
        wide = g->faces == 1 ? 2.0 * s * w * g->height / g->width : (double)w;
        along_x = h < 2 || (w >= 2 && wide >= high);
        m = envlt__find_cut(g, table, &r[i], along_x, r[i].sum.w * half / r[i].lights);
        r[i].cut_x = along_x ? m : 0;
        r[i].cut_y = along_x ? 0 : m;
        envlt__cut_region(&r[i], &r[n]);
        r[n].lights = r[i].lights - half;
        r[i].lights = half;
        r[i].sum.w = envlt__area_energy(g, table, &r[i], r[i].x0, r[i].y0, r[i].x1, r[i].y1);
        r[n].sum.w = envlt__area_energy(g, table, &r[n], r[n].x0, r[n].y0, r[n].x1, r[n].y1);
        n++;
    }
    return n;
}

/* Divides a strip of rows into cells of equal energy, and returns how many. chosen receives the texel in the
   middle of each cell's energy. */
static uint32_t envlt__invert_strip(const envlt__grid *g, const double *table, const envlt__region *strip,
                                    uint32_t cells, uint32_t row, envlt__region *r, uint32_t *chosen)
{
    uint32_t j, n = 0, line;
    double part = strip->sum.w / cells;
    if (strip->x1 - strip->x0 < 2) cells = 1;
    for (j = 0; j < cells; j++) {
        uint32_t column = envlt__locate_energy(g, table, strip, 1, part * (j + 0.5), &line);
        r[n] = *strip;
        if (j) r[n].x0 = envlt__find_cut(g, table, strip, 1, part * j);
        if (j + 1 < cells) r[n].x1 = envlt__find_cut(g, table, strip, 1, part * (j + 1.0));
        if (r[n].x0 >= r[n].x1) continue;
        column = column < r[n].x0 ? r[n].x0 : column >= r[n].x1 ? r[n].x1 - 1 : column;
        chosen[n++] = (strip->face * g->height + row) * g->width + column;
    }
    return n;
}

/* Inverts the cumulative distribution at the centres (i + 0.5) / n of a grid: strips of rows of equal energy
   are divided into cells of equal energy. Cells of one column (row) become one. Returns how many remain. */
static uint32_t envlt__run_inversion(const envlt__grid *g, const double *table, envlt__region *r, uint32_t k,
                                     uint32_t *chosen)
{
    envlt__region faces[6], strip;
    uint32_t f, i, n = 0, line;
    memcpy(faces, r, g->faces * sizeof *faces);
    envlt__share_faces(g, table, faces, k);
    for (f = 0; f < g->faces; f++) {
        const envlt__region *all = &faces[f];
        uint32_t lights = all->lights;
        uint32_t strips = (uint32_t)(sqrt((double)lights * (g->faces == 1 ? 0.5 : 1.0)) + 0.5);
        double part;
        strips = strips < 1 ? 1 : strips > g->height ? g->height : strips;
        part = all->sum.w / strips;
        if (!lights) {                      /* the light of a black face is dropped later, and its texels go
                                               to the nearest light */
            chosen[n] = 0;
            r[n++] = *all;
            continue;
        }
        for (i = 0; i < strips; i++) {
            uint32_t cells = (uint32_t)((uint64_t)(i + 1) * lights / strips - (uint64_t)i * lights / strips);
            uint32_t row = envlt__locate_energy(g, table, all, 0, part * (i + 0.5), &line);
            strip = *all;
            if (i) strip.y0 = envlt__find_cut(g, table, all, 0, part * i);
            if (i + 1 < strips) strip.y1 = envlt__find_cut(g, table, all, 0, part * (i + 1.0));
            if (strip.y0 >= strip.y1) continue;
            row = row < strip.y0 ? strip.y0 : row >= strip.y1 ? strip.y1 - 1 : row;
            strip.sum.w = envlt__area_energy(g, table, &strip, 0, strip.y0, strip.x1, strip.y1);
            n += envlt__invert_strip(g, table, &strip, cells, row, r + n, chosen + n);
        }
    }
    return n;
}

/* Labels each texel with its region. chosen receives the texels that ENVLT_METHOD_CDF picks; other methods
   leave it alone. */
static envlt_result envlt__label_regions(const envlt__grid *g, envlt_method method, uint32_t k,
                                         uint32_t *label, uint32_t *chosen, const envlt__allocator *a)
{
    size_t entries = ((size_t)g->width + 1) * ((size_t)g->height + 1) * g->faces;
    int by_variance = method != ENVLT_METHOD_CDF && method != ENVLT_METHOD_MEDIAN_CUT;
    void *table = envlt__alloc_array(a, entries, by_variance ? sizeof(envlt__moments) : sizeof(double));
    envlt__region *r = table ? (envlt__region *)envlt__alloc_array(a, (size_t)k + 6, sizeof *r) : NULL;
    uint32_t i, n, x, y;

    if (!r) {
        envlt__free(a, table);
        return ENVLT_ERR_ALLOC;
    }
    if (by_variance) envlt__fill_table(g, (envlt__moments *)table);
    else envlt__fill_energy(g, (double *)table);
    memset(r, 0, 6 * sizeof *r);
    for (n = 0; n < g->faces; n++) {
        r[n].face = n;
        r[n].x1 = g->width;
        r[n].y1 = g->height;
    }
    if (by_variance) n = envlt__run_variance(g, (const envlt__moments *)table, r, n, k);
    else if (method == ENVLT_METHOD_CDF) n = envlt__run_inversion(g, (const double *)table, r, k, chosen);
    else n = envlt__run_median(g, (const double *)table, r, n, k);
    for (i = 0; i < n; i++)
        for (y = r[i].y0; y < r[i].y1; y++) {
            uint32_t *row = label + ((size_t)r[i].face * g->height + y) * g->width;
            for (x = r[i].x0; x < r[i].x1; x++) row[x] = i;
        }
    envlt__free(a, r);
    envlt__free(a, table);
    return ENVLT_OK;
}
