/* ---- building: what is seen of a mesh from a sample point ---- */

/* Sets the bits of samples x0 to x1 of a row. */
static void sfield__set_bits(uint64_t *row, int x0, int x1)
{
    int a = x0 >> 6, b = x1 >> 6, w;
    uint64_t first = ~(uint64_t)0 << (x0 & 63), last = ~(uint64_t)0 >> (63 - (x1 & 63));
    if (a == b) row[a] |= first & last;
    else {
        row[a] |= first;
        for (w = a + 1; w < b; w++) row[w] = ~(uint64_t)0;
        row[b] |= last;
    }
}

typedef struct sfield__edges {      /* of a triangle on a face: c[0] s + c[1] t + c[2] >= 0 inside */
    float c[3][3], inverse[3];
    float det;                      /* > 0: counter-clockwise for the eye */
} sfield__edges;

/* Describes a triangle as the cone from the eye through its edges. So nothing is clipped or divided, and an
   edge that two triangles share has the same numbers in both but for their sign: no sample falls between
   them. Returns 0 if the triangle is seen from its edge. */
static int sfield__edges_of(const float *const *corner, uint32_t face, sfield__edges *e)
{
    float q[3][3];
    int i, k;
    for (i = 0; i < 3; i++) sfield__to_face(face, corner[i], q[i]);
    for (i = 0; i < 3; i++) {
        const float *a = q[i], *b = q[(i + 1) % 3];
        e->c[i][0] = a[1] * b[2] - a[2] * b[1];
        e->c[i][1] = a[2] * b[0] - a[0] * b[2];
        e->c[i][2] = a[0] * b[1] - a[1] * b[0];
    }
    e->det = q[2][0] * e->c[0][0] + q[2][1] * e->c[0][1] + q[2][2] * e->c[0][2];
    if (!(e->det > 0 || e->det < 0)) return 0;
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3 && e->det < 0; k++) e->c[i][k] = -e->c[i][k];
        e->inverse[i] = e->c[i][0] != 0 ? 1 / e->c[i][0] : 0.0f;
    }
    return 1;
}

/* Finds the samples of row y inside a triangle. Returns 0 if there are none. box: x0, y0, x1, y1. */
static int sfield__find_span(const sfield__edges *e, uint32_t width, int y, const int *box, int *x0, int *x1)
{
    float half = 0.5f * (float)width, t = ((float)y + 0.5f) / half - 1, low = (float)box[0],
          high = (float)box[2];
    int i;
    for (i = 0; i < 3; i++) {
        float c = e->c[i][1] * t + e->c[i][2], x = (1 - c * e->inverse[i]) * half - 0.5f;
        if (e->c[i][0] > 0) low = x > low ? x : low;
        else if (e->c[i][0] < 0) high = x < high ? x : high;
        else if (c < 0) return 0;
    }
    if (!(low <= high)) return 0;
    *x0 = (int)low + ((float)(int)low < low);
    *x1 = (int)high;
    return *x0 <= *x1;
}

/* Draws a triangle on a face. Sides that do not emit are drawn a little farther away; otherwise those of a
   sheet that shines on both sides would hide its light by rounding. */
static void sfield__raster_face(sfield__view *v, const sfield__edges *e, uint32_t face, const int *box,
                                uint32_t owner)
{
    int y, x, x0;
    int x1, width = (int)v->width;
    float sum[3], half = 0.5f * (float)width, det = e->det > 0 ? e->det : -1.00001f * e->det;
    for (x = 0; x < 3; x++) sum[x] = e->c[0][x] + e->c[1][x] + e->c[2][x];
    for (y = box[1]; y <= box[3]; y++) {
        if (!sfield__find_span(e, v->width, y, box, &x0, &x1)) continue;
        v->row_low[face] = y < v->row_low[face] ? y : v->row_low[face];
        v->row_high[face] = y > v->row_high[face] ? y : v->row_high[face];
        if (!v->depth) {
            sfield__set_bits(v->bits + (size_t)(face * v->width + (uint32_t)y) * (v->width / 64), x0, x1);
            continue;
        }
        for (x = x0; x <= x1; x++) {
            size_t at = (size_t)(face * v->width + (uint32_t)y) * v->width + (uint32_t)x;
            float close =
                (sum[0] * (((float)x + 0.5f) / half - 1) + sum[1] * (((float)y + 0.5f) / half - 1) + sum[2]) /
                det;
            if (close > v->depth[at]) {
                v->depth[at] = close;
                v->owner[at] = owner | (e->det < 0 ? 0x80000000u : 0);      /* the side that does not emit */
            }
        }
    }
}

/* Projects all vertices for an eye, which becomes the origin: finds the face on which each lies, and its
   place on that face. */
static void sfield__project_vertices(const sfield__build *b, sfield__view *v, const float *eye)
{
    size_t i;
    for (i = 0; i < b->vertices; i++) {
        float *c = v->corner + 5 * i, q[3];
        uint32_t face;
        c[0] = b->position[3 * i] - eye[0];
        c[1] = b->position[3 * i + 1] - eye[1];
        c[2] = b->position[3 * i + 2] - eye[2];
        face = sfield__face_of(c);
        sfield__to_face(face, c, q);
        v->face[i] = q[2] > 0 ? (uint8_t)face : 255;
        q[2] = q[2] > 0 ? 0.5f * (float)v->width / q[2] : 0.0f;
        c[3] = q[0] * q[2] + 0.5f * (float)v->width - 0.5f;
        c[4] = q[1] * q[2] + 0.5f * (float)v->width - 0.5f;
    }
}

/* Rounds a box to samples, outwards by a little. Returns 0 if no sample is inside. */
static int sfield__round_box(float x0, float y0, float x1, float y1, uint32_t width, int *box)
{
    float most = (float)width - 1;
    x0 = x0 - 0.01f > 0 ? x0 - 0.01f : 0;
    y0 = y0 - 0.01f > 0 ? y0 - 0.01f : 0;
    x1 = x1 + 0.01f < most ? x1 + 0.01f : most;
    y1 = y1 + 0.01f < most ? y1 + 0.01f : most;
    if (!(x0 <= x1 && y0 <= y1)) return 0;
    box[0] = (int)x0 + ((float)(int)x0 < x0);
    box[1] = (int)y0 + ((float)(int)y0 < y0);
    box[2] = (int)x1;
    box[3] = (int)y1;
    return box[0] <= box[2] && box[1] <= box[3];
}

static float sfield__min3(float a, float b, float c) { return a < b ? (a < c ? a : c) : b < c ? b : c; }
static float sfield__max3(float a, float b, float c) { return a > b ? (a > c ? a : c) : b > c ? b : c; }

/* Draws a triangle that lies over several faces, on each face whose pyramid the triangle may touch. */
static void sfield__raster_across(sfield__view *v, const float *const *corner, uint32_t owner)
{
    sfield__edges e;
    uint32_t face;
    int i;
    for (face = 0; face < 6; face++) {
        int out[5] = { 0, 0, 0, 0, 0 }, box[4];
        float x[3], y[3];
        for (i = 0; i < 3; i++) {
            float q[3];
            sfield__to_face(face, corner[i], q);
            out[0] += q[0] > q[2];
            out[1] += -q[0] > q[2];
            out[2] += q[1] > q[2];
            out[3] += -q[1] > q[2];
            out[4] += q[2] > 0;
            x[i] = q[0] / q[2];
            y[i] = q[1] / q[2];
        }
        if (out[0] == 3 || out[1] == 3 || out[2] == 3 || out[3] == 3 || out[4] == 0) continue;
        if (out[4] < 3) {
            box[0] = box[1] = 0;
            box[2] = box[3] = (int)v->width - 1;
        } else {
            float h = 0.5f * (float)v->width, o = h - 0.5f;
            if (!sfield__round_box(sfield__min3(x[0], x[1], x[2]) * h + o,
                                   sfield__min3(y[0], y[1], y[2]) * h + o,
                                   sfield__max3(x[0], x[1], x[2]) * h + o,
                                   sfield__max3(y[0], y[1], y[2]) * h + o, v->width, box))
                continue;
        }
        if (sfield__edges_of(corner, face, &e)) sfield__raster_face(v, &e, face, box, owner);
    }
}

static void sfield__raster_mesh(const sfield__build *b, sfield__view *v)
{
    size_t t;
    uint32_t face;
    for (face = 0; face < 6; face++) {
        v->row_low[face] = (int)v->width;
        v->row_high[face] = -1;
    }
    for (t = 0; t < b->triangles; t++) {
        const uint32_t *i = b->index + 3 * t;
        const float *c[3];
        uint32_t owner = v->depth ? b->original[t] + 1 : 0;
        sfield__edges e;
        int box[4];
        face = v->face[i[0]];
        c[0] = v->corner + 5 * (size_t)i[0];
        c[1] = v->corner + 5 * (size_t)i[1];
        c[2] = v->corner + 5 * (size_t)i[2];
        if (face != v->face[i[1]] || face != v->face[i[2]] || face == 255) {
            sfield__raster_across(v, c, owner);
            continue;
        }
        if (!sfield__round_box(sfield__min3(c[0][3], c[1][3], c[2][3]),
                               sfield__min3(c[0][4], c[1][4], c[2][4]),
                               sfield__max3(c[0][3], c[1][3], c[2][3]),
                               sfield__max3(c[0][4], c[1][4], c[2][4]), v->width, box))
            continue;
        if (sfield__edges_of(c, face, &e)) sfield__raster_face(v, &e, face, box, owner);
    }
}

/* Adds the drawn samples up to texels, and clears the buffers. */
static void sfield__count_samples(const sfield__build *b, sfield__view *v)
{
    uint32_t n = b->h.cube_side, s = v->scale, words = v->width / 64, face;
    uint32_t x, y, k, c;
    uint64_t mask = s == 64 ? ~(uint64_t)0 : ((uint64_t)1 << s) - 1;
    for (face = 0; face < 6; face++) {
        if (v->row_high[face] < 0) continue;
        for (y = (uint32_t)v->row_low[face] / s; y <= (uint32_t)v->row_high[face] / s; y++) {
            uint64_t *row = v->bits + (size_t)(face * v->width + y * s) * words;
            for (x = 0; x < n && !v->depth; x++) {
                int count = 0;
                for (k = 0; k < s; k++)
                    count += (int)sfield__popcount(row[(size_t)k * words + x * s / 64] >> x * s % 64 & mask);
                v->texel[sfield__texel_number(n, face, x, y)] = (float)count / (float)(s * s);
            }
            if (!v->depth) memset(row, 0, (size_t)s * words * sizeof *row);
        }
        if (!v->depth) continue;
        for (y = (uint32_t)v->row_low[face]; y <= (uint32_t)v->row_high[face]; y++)
            for (x = 0; x < v->width; x++) {
                size_t at = (size_t)(face * v->width + y) * v->width + x;
                uint32_t owner = v->owner[at], texel = sfield__texel_number(n, face, x / s, y / s);
                if (!owner) continue;
                for (c = 0; c < 3; c++)
                    v->texel[c * b->cells + texel] +=
                        (owner >> 31 ? 0.0f : b->radiance[3 * (size_t)(owner - 1) + c]) / (float)(s * s);
                v->depth[at] = 0;
                v->owner[at] = 0;
            }
    }
}

/* Fills the texels of one sample: alpha, or three channels of radiance. */
static void sfield__view_from(const sfield__build *b, sfield__view *v, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->what == SFIELD__EMISSIVE ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, c;
    memset(v->texel, 0, (size_t)b->h.channels * b->cells * sizeof *v->texel);
    /* a word holds the samples of a texel's row */
    if (most > 64 * b->h.cube_side) most = 64 * b->h.cube_side;
    for (v->width = 64; v->width < most && ((float)v->width < 24 * d || v->width < 2 * b->h.cube_side);)
        v->width *= 2;
    if (b->what == SFIELD__SELF) v->width = b->h.cube_side < 32 ? 64 : 2 * b->h.cube_side;
    v->scale = v->width / b->h.cube_side;
    if (b->what == SFIELD__ANALYTIC || b->what == SFIELD__CALLBACK) {
        sfield__sample_cube(b, v, eye);
        for (c = 0; c < b->cells && b->what == SFIELD__CALLBACK; c++)
            v->texel[c] = v->texel[c] < 1 ? v->texel[c] : 1;
        return;
    }
    sfield__project_vertices(b, v, eye);
    sfield__raster_mesh(b, v);
    sfield__count_samples(b, v);
}
