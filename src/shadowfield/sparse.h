/* ---- sparse vertices: shade few, interpolate the rest ---- */

typedef struct sfield__cell { int32_t x, y, z, side; uint32_t point; } sfield__cell;

static int sfield__compare_cells(const void *a, const void *b)
{
    const sfield__cell *p = (const sfield__cell *)a, *q = (const sfield__cell *)b;
    if (p->x != q->x) return p->x < q->x ? -1 : 1;
    if (p->y != q->y) return p->y < q->y ? -1 : 1;
    if (p->z != q->z) return p->z < q->z ? -1 : 1;
    if (p->side != q->side) return p->side < q->side ? -1 : 1;
    return p->point < q->point ? -1 : p->point > q->point;
}

/* Finds a cell by its place and side among sorted cells. Returns NULL if no point lies there. */
static const sfield__cell *sfield__find_cell(const sfield__cell *cells, size_t count,
                                             const sfield__cell *key)
{
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (sfield__compare_cells(&cells[middle], key) < 0) low = middle + 1;
        else high = middle;
    }
    if (low == count || cells[low].x != key->x || cells[low].y != key->y || cells[low].z != key->z ||
        cells[low].side != key->side)
        return NULL;
    return &cells[low];
}

/* Finds the three representatives nearest to a point among the 27 cells around it whose surface faces the
   same way. */
static void sfield__find_sources(const sfield__cell *cells, size_t count, const sfield__cell *own,
                            const sfield_points *points, float spacing, const uint32_t *chosen,
                            uint32_t *sources, float *weights)
{
    float best[3] = { 3e38f, 3e38f, 3e38f }, sum = 0;
    const float *p = sfield__row(points->positions, points->position_stride, own->point),
                unit = sfield__unit(spacing);
    int32_t i;
    uint32_t k, j;
    sources[0] = sources[1] = sources[2] = 0;
    for (i = 0; i < 27; i++) {
        sfield__cell key = *own;
        const sfield__cell *c;
        const float *there;
        float d2 = 0, to;
        key.x += i % 3 - 1;
        key.y += i / 3 % 3 - 1;
        key.z += i / 9 - 1;
        key.point = 0;
        c = sfield__find_cell(cells, count, &key);
        if (!c) continue;
        there = sfield__row(points->positions, points->position_stride, chosen[c->point]);
        for (k = 0; k < 3; k++) {
            to = there[k] * unit - p[k] * unit;
            d2 += to * to;
        }
        for (k = 0; k < 3 && d2 >= best[k]; k++) { }
        for (j = 2; k < 3 && j > k; j--) {
            best[j] = best[j - 1];
            sources[j] = sources[j - 1];
        }
        if (k < 3) {
            best[k] = d2;
            sources[k] = c->point;
        }
    }
    /* inverse distances; the own representative alone where it is hit */
    for (k = 0; k < 3; k++) {
        weights[k] = best[k] < 3e38f ? 1 / (best[k] + 1e-30f) : 0;
        sum += weights[k];
    }
    for (k = 0; k < 3; k++) {
        weights[k] /= sum;
        if (best[k] >= 3e38f) sources[k] = sources[0];
    }
}

/* Checks that all points can be put into cells. */
static sfield_result sfield__check_sparse(const sfield__logger *log, const sfield_points *points,
                                          float spacing)
{
    size_t i, k;
    if (!sfield__points_good(log, points) ||
        !sfield__check_value(log, points->count > 0, "points->count", 0, "> 0") ||
        !sfield__check_value(log, spacing > 0 && sfield__finite(spacing), "spacing", (double)spacing, "> 0"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(log, points->count <= 0x7fffffffu, "points->count", (double)points->count,
                             "below 2^31"))
        return SFIELD_ERR_LIMIT;
    for (i = 0; i < points->count; i++) {
        const float *p = sfield__row(points->positions, points->position_stride, i);
        const float *n = sfield__row(points->normals, points->normal_stride, i);
        for (k = 0; k < 3; k++)
            if (!sfield__in(p[k] / spacing, -1e9f, 1e9f) || !sfield__finite(n[k]))
                return sfield__fail_at(log, SFIELD_ERR_INPUT, "points", i,
                                       "is not finite, or more than 1e9 times the spacing away");
    }
    return SFIELD_OK;
}

/* Finds the cell of each point, a cube and a side, and sorts the points by their cells. */
static void sfield__sort_into_cells(const sfield_points *points, float spacing, sfield__cell *cells)
{
    size_t i, count = points->count;
    uint32_t k;
    for (i = 0; i < count; i++) {
        const float *p = sfield__row(points->positions, points->position_stride, i);
        int32_t at[3];
        for (k = 0; k < 3; k++) at[k] = (int32_t)(p[k] / spacing) - (p[k] < 0);
        cells[i].x = at[0];
        cells[i].y = at[1];
        cells[i].z = at[2];
        cells[i].side = (int32_t)sfield__face_of(sfield__row(points->normals, points->normal_stride, i));
        cells[i].point = (uint32_t)i;
    }
    qsort(cells, count, sizeof *cells, sfield__compare_cells);
}

SFIELD_DEF sfield_result sfield_sparse(const sfield_points *points, float spacing,
                                       const sfield_system *system, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_sparse");
    sfield__allocator a = sfield__allocator_of(system);
    sfield_result result;
    sfield__cell *cells, *first;
    float best = 3e38f;
    size_t i, n = 0, count;
    uint32_t k;
    if (!points || !chosen || !chosen_count || !sources || !weights)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT,
                            !points         ? "points"
                            : !chosen       ? "chosen"
                            : !chosen_count ? "chosen_count"
                            : !sources      ? "sources"
                                            : "weights",
                            "is NULL");
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    result = sfield__check_sparse(&log, points, spacing);
    if (result != SFIELD_OK) return result;
    count = points->count;
    cells = (sfield__cell *)sfield__alloc_array(&a, 2 * count, sizeof *cells);
    if (!cells) return SFIELD_ERR_ALLOC;
    first = cells + count;
    sfield__sort_into_cells(points, spacing, cells);
    for (i = 0; i < count; i++) {               /* the point nearest to a cell's middle stands for it */
        const float *p = sfield__row(points->positions, points->position_stride, cells[i].point);
        float middle[3], d2 = 0;
        middle[0] = (float)cells[i].x;
        middle[1] = (float)cells[i].y;
        middle[2] = (float)cells[i].z;
        for (k = 0; k < 3; k++)
            d2 += (p[k] / spacing - middle[k] - 0.5f) * (p[k] / spacing - middle[k] - 0.5f);
        if (!i || cells[i].x != cells[i - 1].x || cells[i].y != cells[i - 1].y ||
            cells[i].z != cells[i - 1].z || cells[i].side != cells[i - 1].side) {
            first[n] = cells[i];
            first[n].point = (uint32_t)n;
            n++;
            best = 3e38f;
        }
        if (d2 < best) {
            chosen[n - 1] = cells[i].point;
            best = d2;
        }
    }
    for (i = 0; i < count; i++)
        sfield__find_sources(first, n, &cells[i], points, spacing, chosen,
                             sources + 3 * (size_t)cells[i].point, weights + 3 * (size_t)cells[i].point);
    *chosen_count = n;
    sfield__free(&a, cells);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out)
{
    size_t i, k, c;
    if (!sources || !weights || !rgb || !out) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (sources[i] >= chosen_count) return SFIELD_ERR_INPUT;
    for (i = 0; i < count; i++)
        for (c = 0; c < 3; c++) {
            float sum = 0;
            for (k = 0; k < 3; k++) sum += weights[3 * i + k] * rgb[3 * (size_t)sources[3 * i + k] + c];
            out[3 * i + c] = sum;
        }
    return SFIELD_OK;
}
