/* ---- raster: depth of triangles, without a GPU ---- */

/* A corner of a triangle in a tile: x and y in 256ths of a texel, and its depth. */
typedef struct envsh__corner3 { int64_t x, y; float z; } envsh__corner3;

/* Returns what is added to the edge function so that 0 or more means inside: 0 if this triangle owns the
   points on the edge, -1 if its neighbour does. */
static int64_t envsh__edge_bias(const envsh__corner3 *a, const envsh__corner3 *b)
{
    return envsh__edge_owns((double)(b->x - a->x), (double)(b->y - a->y)) ? 0 : -1;
}

/* Returns the edge function of a to b at (x, y), which is above 0 on the left of the edge. */
static int64_t envsh__edge_value(const envsh__corner3 *a, const envsh__corner3 *b, int64_t x, int64_t y)
{
    return (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
}

typedef struct envsh__tile_target { /* the tile that is drawn into */
    float  *tile;                   /* its corner texel */
    size_t  row, step;              /* floats from one row to the next, and from one texel to the next */
    int64_t low, high;              /* the first and the last texel, both ways, that is not guard */
} envsh__tile_target;

/* The texels whose centres may lie in a triangle: columns x0..x1 and rows y0..y1, ends included. */
typedef struct envsh__texel_box { int64_t x0, y0, x1, y1; } envsh__texel_box;

/* Returns the texels of the tile whose centres lie in the box about three corners. If there are none, x0 > x1
   or y0 > y1. */
static envsh__texel_box envsh__bound_texels(const envsh__tile_target *to, const envsh__corner3 *p,
                                            const envsh__corner3 *q, const envsh__corner3 *r)
{
    envsh__texel_box box;
    int64_t x0 = p->x < q->x ? p->x : q->x;
    int64_t x1 = p->x < q->x ? q->x : p->x;
    int64_t y0 = p->y < q->y ? p->y : q->y;
    int64_t y1 = p->y < q->y ? q->y : p->y;
    x0 = ((r->x < x0 ? r->x : x0) + 127) >> 8;       /* the first texel whose centre is not left of the box */
    x1 = ((r->x > x1 ? r->x : x1) - 128) >> 8;
    y0 = ((r->y < y0 ? r->y : y0) + 127) >> 8;
    y1 = ((r->y > y1 ? r->y : y1) - 128) >> 8;
    box.x0 = x0 < to->low ? to->low : x0;
    box.y0 = y0 < to->low ? to->low : y0;
    box.x1 = x1 > to->high ? to->high : x1;
    box.y1 = y1 > to->high ? to->high : y1;
    return box;
}

/* The mask of the triangle that is drawn: its corners are x, y in texels, and 1. */
typedef struct envsh__mask {
    const envsh_mesh *mesh;
    uint32_t          triangle;
    double            corners[9];
} envsh__mask;

/* Returns whether the mask has a hole at the centre of texel x, y. */
static int envsh__is_hole(const envsh__mask *mask, int64_t x, int64_t y)
{
    float weights[3];
    envsh__mask_weights(mask->corners, (double)x + 0.5, (double)y + 0.5, weights);
    return !mask->mesh->mask_fn(mask->mesh->user, mask->triangle, weights);
}

/* Draws the depth of a triangle into the texels of the tile that it covers. mask: NULL = none */
static void envsh__raster_triangle(const envsh__tile_target *to, const envsh__mask *mask,
                                   const envsh__corner3 *p, const envsh__corner3 *q, const envsh__corner3 *r)
{
    const envsh__corner3 *swap;
    envsh__texel_box box;
    int64_t area = envsh__edge_value(p, q, r->x, r->y);
    int64_t x, y;
    int64_t e0, e1, e2;
    int64_t b0, b1, b2;
    float zx, zy, z0;
    float lo, hi;
    double inv;
    if (area == 0) return;
    if (area < 0) {
        swap = q;
        q = r;
        r = swap;
        area = -area;
    }
    box = envsh__bound_texels(to, p, q, r);
    if (box.x0 > box.x1 || box.y0 > box.y1) return;
    /* Depth is a plane over the texels: zx and zy are its slopes. It is kept within lo..hi, the triangle's
       own range, since rounding would lead beyond where triangles are thin. */
    inv = 256.0 / (double)area;
    zx = (float)(((double)(q->z - p->z) * (double)(r->y - p->y) -
                  (double)(r->z - p->z) * (double)(q->y - p->y)) * inv);
    zy = (float)(((double)(r->z - p->z) * (double)(q->x - p->x) -
                  (double)(q->z - p->z) * (double)(r->x - p->x)) * inv);
    lo = p->z < q->z ? p->z : q->z;
    hi = p->z < q->z ? q->z : p->z;
    lo = r->z < lo ? r->z : lo;
    hi = r->z > hi ? r->z : hi;
    lo = lo < 0.0f ? 0.0f : lo;             /* what is nearer than the near plane is in the way all the same
                                               */
    z0 = p->z + zx * ((float)(box.x0 * 256 + 128 - p->x) / 256.0f) +
         zy * ((float)(box.y0 * 256 + 128 - p->y) / 256.0f);
    b0 = envsh__edge_value(p, q, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(p, q);
    b1 = envsh__edge_value(q, r, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(q, r);
    b2 = envsh__edge_value(r, p, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(r, p);
    for (y = box.y0; y <= box.y1; y++) {
        float *out = to->tile + (size_t)y * to->row + (size_t)box.x0 * to->step;
        float zr = z0 + zy * (float)(y - box.y0);
        e0 = b0;
        e1 = b1;
        e2 = b2;
        for (x = box.x0; x <= box.x1; x++, out += to->step) {
            if ((e0 | e1 | e2) >= 0) {
                float z = zr + zx * (float)(x - box.x0);
                z = z < lo ? lo : z > hi ? hi : z;
                if (z < *out && !(mask && envsh__is_hole(mask, x, y))) *out = z;
            }
            e0 -= (q->y - p->y) * 256;
            e1 -= (r->y - q->y) * 256;
            e2 -= (p->y - r->y) * 256;
        }
        b0 += (q->x - p->x) * 256;
        b1 += (r->x - q->x) * 256;
        b2 += (p->x - r->x) * 256;
    }
}

/* Multiplies a row of the lookup by the mesh's transform. */
static void envsh__combine_row(const float *row, const float *m, float *out)
{
    int c;
    for (c = 0; c < 4; c++) {
        out[c] = row[0] * m[4 * c] + row[1] * m[4 * c + 1] + row[2] * m[4 * c + 2];
        if (c == 3) out[c] += row[3];
    }
}

/* Triangles whose corners lie within this many texels of the tile's corner are drawn as they are. Others are
   cut to that reach first, in doubles: floats are too coarse there for 256ths of a texel and for depths. */
#define ENVSH__REACH 32768.0

/* Writes where a corner lies in the tile. Returns 0 if the corner is beyond reach or not finite, in which
   case envsh__cut_triangle decides about the triangle. */
static int envsh__transform_corner(const float *rows, const float *p, envsh__corner3 *out)
{
    const float limit = (float)ENVSH__REACH;
    float x = rows[0] * p[0] + rows[1] * p[1] + rows[2] * p[2] + rows[3];
    float y = rows[4] * p[0] + rows[5] * p[1] + rows[6] * p[2] + rows[7];
    float z = rows[8] * p[0] + rows[9] * p[1] + rows[10] * p[2] + rows[11];
    if (!(fabsf(x) <= limit && fabsf(y) <= limit) || !envsh__finite(z)) return 0;
    out->x = (int64_t)floorf(x * 256.0f + 0.5f);
    out->y = (int64_t)floorf(y * 256.0f + 0.5f);
    out->z = z;
    return 1;
}

/* A point in a tile, in doubles: x and y in texels, and the depth. */
typedef struct envsh__point64 { double p[3]; } envsh__point64;

/* Returns the point where an edge crosses the limit of reach. `in` is its end within reach and `out` its
   other end, din and dout their distances from the limit. The point is computed from the inner end whichever
   way the edge runs, so that both triangles at the edge get the same point. */
static envsh__point64 envsh__cross_reach(const envsh__point64 *in, const envsh__point64 *out, double din,
                                         double dout)
{
    envsh__point64 c;
    int i;
    for (i = 0; i < 3; i++) c.p[i] = in->p[i] + (out->p[i] - in->p[i]) * (din / (din - dout));
    return c;
}

/* Cuts a polygon to the square of what is within reach (Sutherland and Hodgman 1974), and returns how many
   corners are left. q has room for 8 points. */
static int envsh__cut_to_reach(envsh__point64 *q, int count)
{
    envsh__point64 r[8];
    int side, i, n;
    for (side = 0; side < 4 && count > 2; side++) {
        double sign = side & 1 ? -1.0 : 1.0;
        for (i = 0, n = 0; i < count; i++) {
            const envsh__point64 *a = q + i, *b = q + (i + 1 == count ? 0 : i + 1);
            double da = ENVSH__REACH - sign * a->p[side >> 1], db = ENVSH__REACH - sign * b->p[side >> 1];
            if (da >= 0.0) r[n++] = *a;
            if (da >= 0.0 && db < 0.0) r[n++] = envsh__cross_reach(a, b, da, db);
            if (da < 0.0 && db >= 0.0) r[n++] = envsh__cross_reach(b, a, db, da);
        }
        count = n;
        memcpy(q, r, (size_t)n * sizeof *r);
    }
    return count;
}

/* Cuts a triangle to what is within reach, and returns how many corners are left, which is 0 if a corner lies
   where no float does. c has room for 8 corners. */
static int envsh__cut_triangle(const float *rows, const float *const *corners, envsh__corner3 *c)
{
    envsh__point64 q[8];
    int i, k, n;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++) {
            const float *row = rows + 4 * k, *p = corners[i];
            q[i].p[k] = (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                        (double)row[2] * (double)p[2] + (double)row[3];
            if (!(fabs(q[i].p[k]) <= 3e38)) return 0;
        }
    n = envsh__cut_to_reach(q, 3);
    for (i = 0; i < n; i++) {
        c[i].x = (int64_t)floor(q[i].p[0] * 256.0 + 0.5);
        c[i].y = (int64_t)floor(q[i].p[1] * 256.0 + 0.5);
        c[i].z = (float)q[i].p[2];
    }
    return n;
}
