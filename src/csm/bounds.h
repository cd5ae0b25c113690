/* ---- bounds: the sphere and the k-DOP of a mesh ---- */

/* The corners of used triangles, each once, in the order in which the triangles name them. */
typedef struct cohsm__points { float (*at)[3]; size_t count, room; } cohsm__points;

static int cohsm__points_make(cohsm__points *points, const cohsm_mesh *mesh, const uint8_t *used,
                              uint32_t triangles, cohsm__counted_heap *heap)
{
    size_t count = cohsm__triangle_count(mesh), bytes = mesh->vertex_count / 8u + 1u, t;
    uint8_t *met = (uint8_t *)cohsm__heap_alloc(heap, bytes, 1);
    uint32_t scratch[3], i;
    int k;

    points->count = 0;
    points->room = 3 * (size_t)triangles < mesh->vertex_count ? 3 * (size_t)triangles : mesh->vertex_count;
    points->at = (float (*)[3])cohsm__heap_alloc(heap, points->room, sizeof *points->at);
    if (met && points->at) {
        memset(met, 0, bytes);
        for (t = 0; t < count; t++)
            for (k = 0; used[t] && k < 3; k++) {
                i = cohsm__corners(mesh, t, scratch)[k];
                if ((uint32_t)met[i / 8u] >> (i % 8u) & 1u) continue;
                met[i / 8u] = (uint8_t)(met[i / 8u] | 1u << (i % 8u));
                cohsm__v3_store(points->at[points->count++], cohsm__vertex(mesh, i));
            }
    }
    cohsm__heap_free(heap, met, bytes, 1);
    return points->count != 0;
}

static void cohsm__points_free(cohsm__points *points, cohsm__counted_heap *heap)
{
    cohsm__heap_free(heap, points->at, points->room, sizeof *points->at);
}

/* Returns the squared distance of the point that is farthest from the centre, and writes its number; of
   equals the first. */
static double cohsm__farthest(const cohsm__points *points, const double *c, size_t *where)
{
    double far2 = -1.0, d2;
    double x, y, z;
    size_t i;

    *where = 0;
    for (i = 0; i < points->count; i++) {
        x = (double)points->at[i][0] - c[0];
        y = (double)points->at[i][1] - c[1];
        z = (double)points->at[i][2] - c[2];
        d2 = x * x + y * y + z * z;
        if (d2 <= far2) continue;
        far2 = d2;
        *where = i;
    }
    return far2;
}

/* Finds nearly the smallest sphere about the points: from the middle of their box, the centre goes steps of
   1/2, 1/3, 1/4 ... towards the farthest point (Badoiu and Clarkson, "Smaller core-sets for balls", SODA
   2003). */
static void cohsm__fit_sphere(const cohsm__points *points, float *center, float *radius)
{
    double c[3], best = -1.0, far2;
    cohsm__v3 lo = cohsm__v3_load(points->at[0]), hi = lo;
    size_t i;
    int step, k;

    for (i = 1; i < points->count; i++) {
        lo = cohsm__v3_min(lo, cohsm__v3_load(points->at[i]));
        hi = cohsm__v3_max(hi, cohsm__v3_load(points->at[i]));
    }
    c[0] = 0.5 * ((double)lo.x + (double)hi.x);
    c[1] = 0.5 * ((double)lo.y + (double)hi.y);
    c[2] = 0.5 * ((double)lo.z + (double)hi.z);
    for (step = 1; step <= 64; step++) {
        far2 = cohsm__farthest(points, c, &i);
        if (best < 0.0 || far2 < best) {
            best = far2;
            for (k = 0; k < 3; k++) center[k] = (float)c[k];
        }
        for (k = 0; k < 3; k++) c[k] += ((double)points->at[i][k] - c[k]) / (step + 1);
    }
    for (k = 0; k < 3; k++) c[k] = (double)center[k];       /* as it is stored */
    *radius = (float)(sqrt(cohsm__farthest(points, c, &i)) * 1.00001);
}

/* Says whether the sphere holds all points. The radius may be short by a little more than rounding of the
   centre can make it. */
static int cohsm__sphere_holds(const cohsm__points *points, const float *center, float radius)
{
    double c[3];
    size_t i;
    int k;
    for (k = 0; k < 3; k++) c[k] = (double)center[k];
    return cohsm__farthest(points, c, &i) <= (double)radius * (double)radius * 1.0001;
}

/* Returns a direction of the k-DOP. The convex hull of an object is kept as a k-DOP (discrete oriented
   polytope): for each of 13 directions the two planes across it between which the object lies. The directions
   are those from the centre of a cube to its faces, edges and corners. */
static cohsm__v3 cohsm__dop_axis(int i)
{
    static const float axis[COHSM__DOP_AXES][3] = {
        { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 0 }, { 1, -1, 0 }, { 1, 0, 1 }, { 1, 0, -1 },
        { 0, 1, 1 }, { 0, 1, -1 }, { 1, 1, 1 }, { 1, 1, -1 }, { 1, -1, 1 }, { -1, 1, 1 }
    };
    return cohsm__v3_load(axis[i]);
}

static void cohsm__dop_of_sphere(float *dop, const float *center, float radius)
{
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        cohsm__v3 a = cohsm__dop_axis(i);
        float middle = cohsm__v3_dot(a, cohsm__v3_load(center)), reach = cohsm__v3_length(a) * radius;
        dop[2 * i] = middle - reach;
        dop[2 * i + 1] = middle + reach;
    }
}

static void cohsm__dop_of_points(float *dop, const cohsm__points *points)
{
    size_t n;
    int i;
    for (n = 0; n < points->count; n++)
        for (i = 0; i < COHSM__DOP_AXES; i++) {
            float d = cohsm__v3_dot(cohsm__dop_axis(i), cohsm__v3_load(points->at[n]));
            if (!n || d < dop[2 * i]) dop[2 * i] = d;
            if (!n || d > dop[2 * i + 1]) dop[2 * i + 1] = d;
        }
}
