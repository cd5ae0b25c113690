/* ---- raster: the first layers of a triangle mesh ---- */

/* Samples lie at pixel centres; corners are rounded to 1/256 pixel, so that triangles of a shared edge see
   the same corners, and the fill rule gives every sample of that edge to one of them: no sample is counted
   twice or missed. Every bit of the result follows from + - * / and integers; the order of triangles does not
   matter. */

enum { COHSM__CLUSTER = 16, COHSM__SUBPIXEL = 256 };

typedef struct cohsm__soup {            /* triangles in units of the bounding sphere, clusters of 16 */
    float   *v;                         /* of each cluster x0[16] y0[16] z0[16] x1[16] ... z2[16]; the last
                                           cluster is filled up with triangles of no area */
    float   *bounds;                    /* boxes of the clusters in groups of 8: x of the middles of all
                                           eight, then y, z, and in the same way their half sides. After
                                           them come, in groups of 8 too, boxes that each hold 8 clusters */
    const cohsm_mesh *masked;           /* the mesh, if it has a mask; else NULL */
    uint32_t *source;                   /* then the number of each triangle in the mesh */
    uint32_t clusters, triangles;
} cohsm__soup;

typedef struct cohsm__camera {
    int          perspective;
    cohsm__axes  axes;                  /* orthographic: of the image, back towards the light */
    cohsm__v3    eye;                   /* perspective, in units of the bounding sphere about its centre */
    uint32_t     face;
    float        depth_scale;           /* perspective: w (in radii) to depth 0..1 */
} cohsm__camera;

typedef struct cohsm__target {
    uint16_t *z;                        /* `keep` depths a pixel, nearest first; COHSM__INFINITE = no hit */
    uint32_t  keep;                     /* 2 or 4 (the fourth is unused) */
    int       size, row_begin, row_end; /* M, and the rows that are wanted */
} cohsm__target;

/* Enters a depth among the first layers of a pixel, which stay sorted. */
static void cohsm__insert_depth(uint16_t *z, uint32_t keep, uint16_t depth)
{
    uint16_t t;
    if (keep == 2) {                    /* without branches, since nobody can predict them */
        const uint16_t first = z[0], second = z[1], behind = depth > first ? depth : first;
        z[0] = depth < first ? depth : first;
        z[1] = behind < second ? behind : second;
        return;
    }
    if (depth >= z[2]) return;
    z[2] = depth;
    if (z[2] < z[1]) {
        t = z[1];
        z[1] = z[2];
        z[2] = t;
    }
    if (z[1] < z[0]) {
        t = z[0];
        z[0] = z[1];
        z[1] = t;
    }
}

static uint16_t cohsm__depth16(float z)
{
    float s = z * (float)COHSM__HIT_MAX;
    return (uint16_t)(s > 0.0f ? s < (float)COHSM__HIT_MAX ? (int)s : COHSM__HIT_MAX : 0);
}

/* The mask of the triangle that is drawn. Of its corners there are x and y on the image, whose halves are 1
   wide, and w: x and y are not divided by it. */
typedef struct cohsm__mask {
    const cohsm_mesh *mesh;
    uint32_t          triangle;
    double            corners[9];
} cohsm__mask;

/* Says whether the mask has a hole at the centre of pixel x, y of an image of this size. */
static int cohsm__is_hole(const cohsm__mask *mask, int x, int y, int size)
{
    double scale = 2.0 / (double)size;
    float weights[3];
    cohsm__mask_weights(mask->corners, ((double)x + 0.5) * scale - 1.0, ((double)y + 0.5) * scale - 1.0,
                        weights);
    return !mask->mesh->mask_fn(mask->mesh->user, mask->triangle, weights);
}

/* A corner on the image plane: fixed-point position, and depth or 1/w. */
typedef struct cohsm__corner { int32_t x, y; float z; } cohsm__corner;

/* Says whether the edge from a to b leaves the samples exactly on it to the neighbouring triangle, which sees
   the edge from b to a; else the edge takes these samples. */
static int cohsm__edge_loses(const cohsm__corner *a, const cohsm__corner *b)
{
    return !(b->y > a->y || (b->y == a->y && b->x > a->x));
}

/* Returns twice the area that the edge from a to b makes with the point (x, y); positive on its left. */
static int64_t cohsm__edge_area(const cohsm__corner *a, const cohsm__corner *b, int32_t x, int32_t y)
{
    return (int64_t)(b->x - a->x) * (y - a->y) - (int64_t)(b->y - a->y) * (x - a->x);
}

/* The samples in columns x0..x1 and rows y0..y1. */
typedef struct cohsm__samples { int32_t x0, x1, y0, y1; } cohsm__samples;

/* Finds the samples in the box of a triangle that are on the image and in the wanted rows. Returns 0 if there
   are none. */
static int cohsm__samples_in_box(const cohsm__target *t, const cohsm__corner *p0, const cohsm__corner *p1,
                                 const cohsm__corner *p2, cohsm__samples *s)
{
    int32_t lx = p0->x < p1->x ? p0->x : p1->x, hx = p0->x > p1->x ? p0->x : p1->x;
    int32_t ly = p0->y < p1->y ? p0->y : p1->y, hy = p0->y > p1->y ? p0->y : p1->y;

    if (p2->x < lx) lx = p2->x;
    if (p2->x > hx) hx = p2->x;
    if (p2->y < ly) ly = p2->y;
    if (p2->y > hy) hy = p2->y;
    /* The samples are those x * 256 + 128 within lx..hx; lx and hx are clamped first, since shifts of
       negative numbers are not portable. */
    s->x0 = lx <= 128 ? 0 : (lx + 127) >> 8;
    s->y0 = ly <= 128 + 256 * t->row_begin ? t->row_begin : (ly + 127) >> 8;
    s->x1 = hx < 128 ? -1 : (hx - 128) >> 8;
    s->y1 = hy < 128 ? -1 : (hy - 128) >> 8;
    if (s->x1 >= t->size) s->x1 = t->size - 1;
    if (s->y1 >= t->row_end) s->y1 = t->row_end - 1;
    return s->x0 <= s->x1 && s->y0 <= s->y1;
}

/* Enters the depths of a triangle, sample by sample. mask: NULL = none */
static void cohsm__fill_triangle(const cohsm__target *t, const cohsm__camera *cam, const cohsm__mask *mask,
                                 const cohsm__corner *p0, const cohsm__corner *p1, const cohsm__corner *p2)
{
    int64_t area = (int64_t)(p1->x - p0->x) * (p2->y - p0->y) - (int64_t)(p1->y - p0->y) * (p2->x - p0->x);
    int64_t w0, w1, w2;
    int64_t s0, s1, s2;
    int e0, e1, e2;
    int32_t x, y;
    cohsm__samples box;
    const cohsm__corner *swap;
    float scale, z;

    if (area == 0) return;
    if (area < 0) {
        swap = p1;
        p1 = p2;
        p2 = swap;
        area = -area;
    }
    if (!cohsm__samples_in_box(t, p0, p1, p2, &box)) return;
    s0 = cohsm__edge_area(p1, p2, box.x0 * 256 + 128, box.y0 * 256 + 128);
    s1 = cohsm__edge_area(p2, p0, box.x0 * 256 + 128, box.y0 * 256 + 128);
    s2 = cohsm__edge_area(p0, p1, box.x0 * 256 + 128, box.y0 * 256 + 128);
    e0 = cohsm__edge_loses(p1, p2);
    e1 = cohsm__edge_loses(p2, p0);
    e2 = cohsm__edge_loses(p0, p1);
    scale = 1.0f / (float)area;
    for (y = box.y0; y <= box.y1; y++) {
        w0 = s0;
        w1 = s1;
        w2 = s2;
        for (x = box.x0; x <= box.x1; x++) {
            if (w0 >= e0 && w1 >= e1 && w2 >= e2 && !(mask && cohsm__is_hole(mask, x, y, t->size))) {
                z = ((float)w0 * p0->z + (float)w1 * p1->z + (float)w2 * p2->z) * scale;
                if (cam->perspective) z = cam->depth_scale / z;
                cohsm__insert_depth(t->z + (size_t)t->keep * (size_t)(y * t->size + x), t->keep,
                                    cohsm__depth16(z));
            }
            w0 -= (int64_t)(p2->y - p1->y) * 256;
            w1 -= (int64_t)(p0->y - p2->y) * 256;
            w2 -= (int64_t)(p1->y - p0->y) * 256;
        }
        s0 += (int64_t)(p2->x - p1->x) * 256;
        s1 += (int64_t)(p0->x - p2->x) * 256;
        s2 += (int64_t)(p1->x - p0->x) * 256;
    }
}

static const float *cohsm__cluster(const cohsm__soup *soup, uint32_t i)
{
    return soup->v + (size_t)i * 9 * COHSM__CLUSTER;
}

/* Returns how many groups of eight hold count boxes, which are those of clusters or of 8 clusters each. */
static uint32_t cohsm__groups_of_8(uint32_t count) { return (count + 7u) / 8u; }
static size_t cohsm__bound_count(const cohsm__soup *soup)
{
    uint32_t groups = cohsm__groups_of_8(soup->clusters);
    return (size_t)groups + cohsm__groups_of_8(groups);
}
static float *cohsm__wide_bounds(const cohsm__soup *soup)
{
    return soup->bounds + 48 * (size_t)cohsm__groups_of_8(soup->clusters);
}

/* Returns which of 8 clusters may cover samples of the wanted rows of a perspective view, one bit each. */
static unsigned cohsm__face_sees8(const cohsm__target *t, const cohsm__camera *cam, const float *box)
{
    float half = 0.5f * (float)t->size, low = ((float)t->row_begin + 0.49f) / half - 1.0f;
    float high = ((float)t->row_end - 0.49f) / half - 1.0f;
    float x, y, w;
    float ex, ey, ew;
    unsigned mask = 0;
    int i;

    for (i = 0; i < 8; i++) {
        cohsm__v3 c = cohsm__v3_make(box[i], box[8 + i], box[16 + i]);
        cohsm__face_coordinates(cam->face, cohsm__v3_sub(c, cam->eye), &x, &y, &w);
        cohsm__face_coordinates(cam->face, cohsm__v3_make(box[24 + i], box[32 + i], box[40 + i]),
                                &ex, &ey, &ew);
        ex = fabsf(ex);
        ey = fabsf(ey);
        ew = fabsf(ew);
        if (w + ew > 0.0f && fabsf(x) - w <= ex + ew && y - low * w >= -ey - fabsf(low) * ew &&
            y - high * w <= ey + fabsf(high) * ew)
            mask |= 1u << i;
    }
    return mask;
}

/* Depths wait to be entered until there are many: how many of the lanes that are drawn together hit is
   anybody's guess, and a loop over each few hits ends where no predictor expects it. */
enum { COHSM__MANY = 80, COHSM__QUEUE = COHSM__MANY + 32 };         /* kernels write 16 entries at a time */
typedef struct cohsm__hits {
    int32_t  pixel[COHSM__QUEUE], area[COHSM__QUEUE], depth[COHSM__QUEUE];
    float    sum[COHSM__QUEUE];         /* of the corners' depths, each by its part of the area */
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__hits;

static void cohsm__insert_hits(const cohsm__target *t, cohsm__hits *hits)
{
    uint32_t i;
    for (i = 0; i < hits->count; i++)
        cohsm__insert_depth(t->z + (size_t)t->keep * (uint32_t)hits->pixel[i], t->keep,
                            (uint16_t)hits->depth[i]);
    hits->count = 0;
}

/* Specks are triangles whose box holds one sample, so that their corners lie up to 255/256 pixel from it. On
   a fine mesh nearly all that hold any are specks. */
typedef struct cohsm__specks {
    int32_t  corner[3][COHSM__QUEUE];   /* as seen from the sample: x in the low half, y in the high half */
    float    z[3][COHSM__QUEUE];
    int32_t  pixel[COHSM__QUEUE];
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__specks;

/* Triangles whose boxes hold samples wait in a queue until there are many; then as many as there are lanes
   are drawn together. On a fine mesh one triangle in five holds samples, and no branch predictor knows which
   one: a branch after each triangle costs more than setting the triangle up. */
typedef struct cohsm__queue {
    int32_t  x[3][COHSM__QUEUE], y[3][COHSM__QUEUE];
    float    z[3][COHSM__QUEUE];
    uint32_t count, fill[15];           /* fills a cache line */
    cohsm__specks specks;               /* are not among the others */
    cohsm__hits   hits;
} cohsm__queue;

/* Directions of one column of the sphere have one axis to the right: of a mesh whose triangles are smaller
   than a pixel, most have no sample column between their corners and are left out of all these views at
   once. Up to COHSM__ABREAST views are drawn together, a slab of the mesh after the other: of its
   triangles, those that hold a sample column, with x on the images and all three corners. Views of other
   axes are drawn together as well, since each slab is then near when the next one reads it. */
enum { COHSM__ABREAST = 8, COHSM__SLAB = 16 * COHSM__CLUSTER, COHSM__CLUSTERS_AHEAD = 12 };
typedef struct cohsm__slab {
    int32_t  x[3][COHSM__SLAB + 16];    /* kernels write 16 entries at a time */
    int32_t  off[3][COHSM__SLAB + 16];  /* of corners from the middle of the sample column */
    int32_t  column[COHSM__SLAB + 16];  /* the one sample column, or -1 if there are several */
    float    corner[9][COHSM__SLAB + 16];
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__slab;
typedef struct cohsm__column { cohsm__slab slab; cohsm__queue queue[COHSM__ABREAST]; } cohsm__column;

/* Lists which of COHSM__STRETCH neighbouring clusters are in sight. The list has room for eight more, since
   kernels write eight entries at a time. */
enum { COHSM__STRETCH = 512 };
typedef struct cohsm__sight { uint32_t cluster[COHSM__STRETCH + 8], count; } cohsm__sight;

/* Returns a mask of 8 bits with the first count set. */
static unsigned cohsm__first8(uint32_t count) { return count < 8 ? (1u << count) - 1u : 255u; }
