/* ---- soup: triangles sorted in space ---- */

/* Writes the corners of a triangle in units of the sphere. */
static void cohsm__soup_corners(const cohsm_mesh *mesh, size_t triangle, cohsm__v3 center, float inverse,
                                cohsm__v3 *p)
{
    uint32_t scratch[3];
    const uint32_t *corner = cohsm__corners(mesh, triangle, scratch);
    int k;
    for (k = 0; k < 3; k++)
        p[k] = cohsm__v3_scale(cohsm__v3_sub(cohsm__vertex(mesh, corner[k]), center), inverse);
}

/* A triangle and where it lies: `at` is the sum of its corners. */
typedef struct cohsm__spot { float at[3]; uint32_t triangle; } cohsm__spot;

/* Returns which of 256 bins along an axis a triangle falls into. */
static uint32_t cohsm__bin_of(const cohsm__spot *p, int axis, float low, float scale)
{
    return cohsm__min_u32((uint32_t)((p->at[axis] - low) * scale), 255u);
}

/* Moves the first `half` triangles along the longest axis of their box to the front. Triangles are counted in
   256 bins; those in the bin of the limit may go to either side, so that the time is linear whatever the
   mesh. */
static void cohsm__halve_spots(cohsm__spot *p, uint32_t count, uint32_t half)
{
    uint32_t bins[256], i, middle;
    uint32_t left, store, bin;
    float low[3], high[3], scale;
    cohsm__spot moved;
    int axis = 0, k;

    for (k = 0; k < 3; k++) low[k] = high[k] = p->at[k];
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            low[k] = p[i].at[k] < low[k] ? p[i].at[k] : low[k];
            high[k] = p[i].at[k] > high[k] ? p[i].at[k] : high[k];
        }
    for (k = 1; k < 3; k++)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    if (!(high[axis] - low[axis] > 1e-30f)) return;
    scale = 255.0f / (high[axis] - low[axis]);
    memset(bins, 0, sizeof bins);
    for (i = 0; i < count; i++) bins[cohsm__bin_of(p + i, axis, low[axis], scale)]++;
    for (middle = 0, left = half; bins[middle] <= left && middle < 255u; middle++) left -= bins[middle];
    for (i = 0, store = 0; i < count; i++) {
        bin = cohsm__bin_of(p + i, axis, low[axis], scale);
        if (bin > middle || (bin == middle && !left)) continue;
        left -= (uint32_t)(bin == middle);
        moved = p[i];
        p[i] = p[store];
        p[store++] = moved;
    }
}

/* Sorts the triangles of a leaf into the order of the mesh: neighbours of a mesh often fare alike, so that
   branches are foreseen better. */
static void cohsm__sort_leaf(cohsm__spot *p, uint32_t count)
{
    uint32_t i, j;
    for (i = 1; i < count; i++) {
        cohsm__spot moved = p[i];
        for (j = i; j && p[j - 1u].triangle > moved.triangle; j--) p[j] = p[j - 1u];
        p[j] = moved;
    }
}

/* Sorts triangles so that neighbours in space stand one after the other: by halves of halves, in whole
   clusters and, above these, in eights of clusters. todo has room for any mesh: a half is no larger than the
   rest by more than a unit. */
static void cohsm__sort_spots(cohsm__spot *p, uint32_t count)
{
    enum { LEAF = COHSM__CLUSTER };
    struct { cohsm__spot *p; uint32_t count; } todo[32];
    uint32_t waiting = 0, unit, half;

    for (;;)
        if (count > LEAF) {
            unit = count > 8 * LEAF ? 8 * LEAF : LEAF;
            half = (count + unit - 1u) / unit / 2u * unit;
            cohsm__halve_spots(p, count, half);
            todo[waiting].p = p + half;
            todo[waiting++].count = count - half;
            count = half;
        } else {
            cohsm__sort_leaf(p, count);
            if (!waiting) return;
            p = todo[--waiting].p;
            count = todo[waiting].count;
        }
}

/* Writes the box of clusters that lie one after the other, a little enlarged. */
static void cohsm__bound_clusters(const float *v, uint32_t clusters, float *box)
{
    float low[3] = { 2.0f, 2.0f, 2.0f }, high[3] = { -2.0f, -2.0f, -2.0f };
    uint32_t i, k;
    for (i = 0; i < 9 * COHSM__CLUSTER * clusters; i++) {
        k = i / COHSM__CLUSTER % 3;
        low[k] = v[i] < low[k] ? v[i] : low[k];
        high[k] = v[i] > high[k] ? v[i] : high[k];
    }
    for (k = 0; k < 3; k++) {
        box[8 * k] = 0.5f * (low[k] + high[k]);
        box[24 + 8 * k] = 0.5f * (high[k] - low[k]) + 1e-5f;
    }
}

/* Writes a box for every `span` clusters, from bounds on. */
static void cohsm__bound_all_clusters(const cohsm__soup *soup, uint32_t span, float *bounds)
{
    uint32_t i, at;
    for (i = 0, at = 0; i < soup->clusters; i += span, at++)
        cohsm__bound_clusters(cohsm__cluster(soup, i), cohsm__min_u32(span, soup->clusters - i),
                              bounds + 48 * (size_t)(at / 8) + at % 8);
}

static void cohsm__soup_fill(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used,
                             cohsm__spot *spot, cohsm__v3 center, float inverse)
{
    size_t count = cohsm__triangle_count(mesh), t;
    cohsm__v3 p[3];
    uint32_t n = 0;
    float *v;
    int k;

    for (t = 0; t < count; t++) {
        if (!used[t]) continue;
        cohsm__soup_corners(mesh, t, center, inverse, p);
        cohsm__v3_store(spot[n].at, cohsm__v3_add(cohsm__v3_add(p[0], p[1]), p[2]));
        spot[n++].triangle = (uint32_t)t;
    }
    cohsm__sort_spots(spot, n);
    for (n = 0; n < soup->triangles; n++) {
        cohsm__soup_corners(mesh, spot[n].triangle, center, inverse, p);
        if (soup->masked) soup->source[n] = spot[n].triangle;
        for (k = 0; k < 3; k++) {
            v = soup->v + (size_t)(n / COHSM__CLUSTER) * 9 * COHSM__CLUSTER + 3 * COHSM__CLUSTER * k +
                n % COHSM__CLUSTER;
            v[0] = p[k].x;
            v[COHSM__CLUSTER] = p[k].y;
            v[2 * COHSM__CLUSTER] = p[k].z;
        }
    }
}

/* Makes the clusters of a mesh: triangles are sorted in space, so that clusters are small and a shard need
   not look into most of them. Returns 0 if memory runs out; cohsm__soup_free is due in either case. */
static int cohsm__soup_make(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used,
                            uint32_t triangles, const float *center, float radius, cohsm__counted_heap *heap)
{
    cohsm__spot *spot;
    size_t floats;
    int made;

    soup->triangles = triangles;
    soup->clusters = (triangles + COHSM__CLUSTER - 1) / COHSM__CLUSTER;
    floats = (size_t)soup->clusters * 9 * COHSM__CLUSTER;
    soup->v = (float *)cohsm__heap_alloc(heap, floats, sizeof(float));
    soup->bounds = (float *)cohsm__heap_alloc(heap, cohsm__bound_count(soup), 48 * sizeof(float));
    spot = (cohsm__spot *)cohsm__heap_alloc(heap, triangles, sizeof *spot);
    soup->masked = mesh->mask_fn ? mesh : NULL;
    soup->source = NULL;
    if (soup->masked) soup->source = (uint32_t *)cohsm__heap_alloc(heap, triangles, sizeof *soup->source);
    made = soup->v && soup->bounds && spot && (!soup->masked || soup->source);
    if (made) {
        memset(soup->v, 0, floats * sizeof(float));
        memset(soup->bounds, 0, cohsm__bound_count(soup) * 48 * sizeof(float));
        cohsm__soup_fill(soup, mesh, used, spot, cohsm__v3_load(center), 1.0f / radius);
        cohsm__bound_all_clusters(soup, 1, soup->bounds);
        cohsm__bound_all_clusters(soup, 8, cohsm__wide_bounds(soup));
    }
    cohsm__heap_free(heap, spot, triangles, sizeof *spot);
    return made;
}

static void cohsm__soup_free(cohsm__soup *soup, cohsm__counted_heap *heap)
{
    cohsm__heap_free(heap, soup->v, (size_t)soup->clusters * 9 * COHSM__CLUSTER, sizeof(float));
    cohsm__heap_free(heap, soup->bounds, cohsm__bound_count(soup), 48 * sizeof(float));
    cohsm__heap_free(heap, soup->source, soup->triangles, sizeof *soup->source);
    soup->v = soup->bounds = NULL;
    soup->source = NULL;
}
