/* ---- raster: whole views, clipped where they are perspective ---- */

/* Triangles of perspective views are cut to |x|, |y| <= 2 w, so that fixed-point positions stay small, and to
   w >= near. */
typedef struct cohsm__clip { float x, y, w; } cohsm__clip;

static float cohsm__clip_distance(const cohsm__clip *c, int plane)
{
    switch (plane) {
    case 0: return c->w - 1e-5f;
    case 1: return 2.0f * c->w - c->x;
    case 2: return 2.0f * c->w + c->x;
    case 3: return 2.0f * c->w - c->y;
    default: return 2.0f * c->w + c->y;
    }
}

/* Computes the cut from the inner end, whichever way the edge runs, so that both triangles of the edge get
   the same corner. */
static cohsm__clip cohsm__clip_cut(const cohsm__clip *in, const cohsm__clip *out, float din, float dout)
{
    cohsm__clip c;
    float t = din / (din - dout);
    c.x = in->x + (out->x - in->x) * t;
    c.y = in->y + (out->y - in->y) * t;
    c.w = in->w + (out->w - in->w) * t;
    return c;
}

static int cohsm__clip_polygon(cohsm__clip *p, int count)
{
    cohsm__clip q[10];
    int plane, i, n;

    for (plane = 0; plane < 5; plane++) {
        for (i = 0, n = 0; i < count; i++) {
            const cohsm__clip *a = p + i, *b = p + (i + 1 == count ? 0 : i + 1);
            float da = cohsm__clip_distance(a, plane), db = cohsm__clip_distance(b, plane);
            if (da >= 0.0f) q[n++] = *a;
            if (da >= 0.0f && db < 0.0f) q[n++] = cohsm__clip_cut(a, b, da, db);
            if (da < 0.0f && db >= 0.0f) q[n++] = cohsm__clip_cut(b, a, db, da);
        }
        count = n;
        if (count < 3) return 0;
        memcpy(p, q, sizeof *p * (size_t)count);
    }
    return count;
}

static cohsm__corner cohsm__project_corner(const cohsm__clip *c, int size)
{
    cohsm__corner p;
    float scale = (float)(size * (COHSM__SUBPIXEL / 2)), inverse = 1.0f / c->w, offset = scale * 3.0f + 0.5f;
    /* The offset by one image makes the number positive, so that conversion to int truncates downwards
       everywhere. */
    p.x = (int32_t)(c->x * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.y = (int32_t)(c->y * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.z = inverse;
    return p;
}

/* Begins the mask of triangle `lane` of a cluster. Returns NULL if the mesh has none. */
static cohsm__mask *cohsm__mask_begin(const cohsm__soup *soup, uint32_t cluster, uint32_t lane,
                                      cohsm__mask *mask)
{
    uint32_t number = cluster * COHSM__CLUSTER + lane;
    if (!soup->masked || number >= soup->triangles) return NULL;
    mask->mesh = soup->masked;
    mask->triangle = soup->source[number];
    return mask;
}

static void cohsm__mask_corner(cohsm__mask *mask, int corner, float x, float y, float w)
{
    mask->corners[3 * corner] = (double)x;
    mask->corners[3 * corner + 1] = (double)y;
    mask->corners[3 * corner + 2] = (double)w;
}

static void cohsm__raster_perspective(const cohsm__target *t, const cohsm__camera *cam,
                                      const cohsm__soup *soup, uint32_t cluster, uint32_t lane)
{
    const float *v = cohsm__cluster(soup, cluster);
    cohsm__mask storage, *mask = cohsm__mask_begin(soup, cluster, lane, &storage);
    cohsm__clip p[10];
    cohsm__corner c0, c1, c2;
    int k, n = 3, behind = 0;
    int left = 0, right = 0, below = 0, above = 0;
    int inside = 0;

    for (k = 0; k < 3; k++, v += 3 * COHSM__CLUSTER) {
        cohsm__v3 q = cohsm__v3_sub(cohsm__v3_make(v[lane], v[16 + lane], v[32 + lane]), cam->eye);
        cohsm__face_coordinates(cam->face, q, &p[k].x, &p[k].y, &p[k].w);
        if (mask) cohsm__mask_corner(mask, k, p[k].x, p[k].y, p[k].w);
        behind += p[k].w < 1e-5f;
        left += p[k].x < -p[k].w;
        right += p[k].x > p[k].w;
        below += p[k].y < -p[k].w;
        above += p[k].y > p[k].w;
        inside += p[k].w >= 1e-5f && fabsf(p[k].x) <= 2.0f * p[k].w && fabsf(p[k].y) <= 2.0f * p[k].w;
    }
    if (behind == 3 || left == 3 || right == 3 || below == 3 || above == 3) return;
    if (inside < 3) n = cohsm__clip_polygon(p, 3);
    if (n < 3) return;
    c0 = cohsm__project_corner(p, t->size);
    c1 = cohsm__project_corner(p + 1, t->size);
    for (k = 2; k < n; k++) {
        c2 = cohsm__project_corner(p + k, t->size);
        cohsm__fill_triangle(t, cam, mask, &c0, &c1, &c2);
        c1 = c2;
    }
}

/* Says whether the unit sphere can be seen in this face at all. */
static int cohsm__face_sees_sphere(const cohsm__camera *cam)
{
    cohsm__v3 q = cohsm__v3_scale(cam->eye, -1.0f);
    float x, y, w;
    cohsm__face_coordinates(cam->face, q, &x, &y, &w);
    return w > -1.001f && fabsf(x) - w < 1.4157f && fabsf(y) - w < 1.4157f;
}

/* Appends to a list the numbers, from first on, of the bits that are set. Returns the new count. */
static uint32_t cohsm__append_set_bits(uint32_t *list, uint32_t count, unsigned mask, uint32_t first)
{
    for (; mask; mask >>= 1, first++)
        if (mask & 1u) list[count++] = first;
    return count;
}

/* Finds those of the clusters begin .. end - 1, no more than a stretch, that may be in sight of a perspective
   view: by the boxes of eight clusters first. */
static void cohsm__find_in_face(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                                uint32_t begin, uint32_t end, cohsm__sight *sight)
{
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__groups_of_8(end), count = 0, i;
    unsigned mask;

    for (i = begin / 8; i < eights; i += 8) {
        mask = cohsm__face_sees8(t, cam, wide + 6 * (size_t)i) & cohsm__first8(eights - i);
        count = cohsm__append_set_bits(eight, count, mask, i);
    }
    for (i = 0, sight->count = 0; i < count; i++) {
        mask = cohsm__face_sees8(t, cam, soup->bounds + 48 * (size_t)eight[i]) &
               cohsm__first8(end - 8 * eight[i]);
        sight->count = cohsm__append_set_bits(sight->cluster, sight->count, mask, 8 * eight[i]);
    }
}

static void cohsm__raster_face(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup)
{
    cohsm__sight sight;
    uint32_t begin, end, i, k;

    if (!cohsm__face_sees_sphere(cam)) return;
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        cohsm__find_in_face(t, cam, soup, begin, end, &sight);
        for (i = 0; i < sight.count; i++)
            for (k = 0; k < COHSM__CLUSTER; k++)
                cohsm__raster_perspective(t, cam, soup, sight.cluster[i], k);
    }
}

/* Draws a triangle of an orthographic view as the kernels do, to the last bit, but for the holes of its
   mask. */
static void cohsm__raster_masked(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                                 uint32_t cluster, uint32_t lane)
{
    const float scale = (float)(t->size * (COHSM__SUBPIXEL / 2)), offset = scale + 0.5f;
    const cohsm__v3 right = cohsm__v3_scale(cam->axes.right, scale);
    const cohsm__v3 up = cohsm__v3_scale(cam->axes.up, scale);
    const float *v = cohsm__cluster(soup, cluster);
    cohsm__mask mask;
    cohsm__corner c[3];
    int k;

    if (!cohsm__mask_begin(soup, cluster, lane, &mask)) return;
    for (k = 0; k < 3; k++, v += 3 * COHSM__CLUSTER) {
        cohsm__v3 p = cohsm__v3_make(v[lane], v[16 + lane], v[32 + lane]);
        c[k].x = (int32_t)(cohsm__v3_dot(p, right) + offset);
        c[k].y = (int32_t)(cohsm__v3_dot(p, up) + offset);
        c[k].z = 0.5f - 0.5f * cohsm__v3_dot(p, cam->axes.back);
        cohsm__mask_corner(&mask, k, cohsm__v3_dot(p, cam->axes.right), cohsm__v3_dot(p, cam->axes.up), 1.0f);
    }
    cohsm__fill_triangle(t, cam, &mask, c, c + 1, c + 2);
}

/* Draws a perspective view, or an orthographic one of a mesh with a mask. */
static void cohsm__raster_view(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                               int simd)
{
    size_t first = (size_t)(t->row_begin * t->size) * t->keep;
    size_t last = (size_t)(t->row_end * t->size) * t->keep;
    int all = t->row_begin == 0 && t->row_end == t->size;
    cohsm__kernels kernels = cohsm__choose_kernels(simd);
    uint32_t begin, end, i;
    cohsm__sight sight;

    memset(t->z + first, 0xff, (last - first) * sizeof *t->z);
    if (cam->perspective) {
        cohsm__raster_face(t, cam, soup);
        return;
    }
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        for (i = begin; all && i < end; i++) sight.cluster[i - begin] = i;
        sight.count = end - begin;
        if (!all) kernels.find(t, cam->axes.up, soup, begin, end, &sight);
        for (i = 0; i < sight.count * COHSM__CLUSTER; i++)
            cohsm__raster_masked(t, cam, soup, sight.cluster[i / COHSM__CLUSTER], i % COHSM__CLUSTER);
    }
}

/* Lists those of the clusters begin .. end - 1, no more than a stretch, that one of the views may see. */
static void cohsm__sight_of_column(const cohsm__target *t, const cohsm__camera *cam, uint32_t count,
                                   const cohsm__soup *soup, const cohsm__kernels *kernels, uint32_t begin,
                                   uint32_t end, cohsm__sight *sight)
{
    const int all = t->row_begin == 0 && t->row_end == t->size;
    uint8_t seen[COHSM__STRETCH];
    uint32_t i, k;

    memset(seen, all, sizeof seen);
    for (i = 0; !all && i < count; i++) {
        kernels->find(t + i, cam[i].axes.up, soup, begin, end, sight);
        for (k = 0; k < sight->count; k++) seen[sight->cluster[k] - begin] = 1;
    }
    for (k = begin, sight->count = 0; k < end; k++)
        if (seen[k - begin]) sight->cluster[sight->count++] = k;
}

static int cohsm__right_is_same(const cohsm__camera *a, const cohsm__camera *b)
{
    return !memcmp(&a->axes.right, &b->axes.right, sizeof a->axes.right);
}

/* Draws orthographic views of a mesh without a mask, faster if their axes to the right are the same. */
static void cohsm__raster_column(const cohsm__target *t, const cohsm__camera *cam, uint32_t count,
                                 const cohsm__soup *soup, int simd, cohsm__column *column)
{
    const size_t first = (size_t)(t->row_begin * t->size) * t->keep;
    const size_t last = (size_t)(t->row_end * t->size) * t->keep;
    const cohsm__kernels kernels = cohsm__choose_kernels(simd);
    uint32_t begin, end, at, i;
    cohsm__sight sight;

    for (i = 0; i < count; i++) memset(t[i].z + first, 0xff, (last - first) * sizeof *t->z);
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        cohsm__sight_of_column(t, cam, count, soup, &kernels, begin, end, &sight);
        for (at = 0; at < sight.count; at += (uint32_t)COHSM__SLAB / COHSM__CLUSTER) {
            for (i = 0; i < count; i++) {
                if (!i || !cohsm__right_is_same(cam + i, cam + i - 1))
                    kernels.find_slab(t + i, cam + i, soup, &sight, at, &column->slab);
                kernels.enqueue_slab(t + i, cam + i, &column->slab, column->queue + i);
            }
        }
    }
    for (i = 0; i < count; i++) kernels.draw_queue(t + i, cam + i, column->queue + i, 1);
}
