/* ---- curve: an emissive mesh as small pieces along a space-filling curve ---- */

typedef struct lsamp__piece {       /* a triangle, or a part of one */
    double   end;                   /* the share of all area that this piece and those before it have */
    uint64_t key;                   /* the place on the curve; the lowest 31 bits number the pieces, so that
                                       no two keys are equal */
    float    v[9], normal[3];
} lsamp__piece;

typedef struct lsamp__curve {       /* an emissive mesh */
    lsamp__piece *pieces;           /* in the order of the curve */
    float        *locations;        /* places for maps, four floats each */
    double        area;
    uint32_t      count, places;    /* of pieces; of locations */
} lsamp__curve;

static uint32_t lsamp__place_count(const lsamp_light_desc *d)
{
    return d->place_count ? d->place_count : 1024u;
}

/* Returns the most pieces that a mesh can be cut into. A triangle that is halved until its pieces are at most
   area / (2 places) gives fewer than 2 x 2 places x its share of the area, or is one piece. */
static size_t lsamp__most_pieces(const lsamp_light_desc *d)
{
    return lsamp__triangle_count(d->mesh) + 4u * (size_t)lsamp__place_count(d) + 1u;
}

static size_t lsamp__curve_size(const lsamp_light_desc *d)
{
    size_t bytes;
    if (!lsamp__mul_size(lsamp__most_pieces(d), sizeof(lsamp__piece), &bytes) ||
        !lsamp__add_size(bytes, 16u * (size_t)lsamp__place_count(d) + 16u + sizeof(lsamp__curve), &bytes))
        return 0;
    return bytes & ~(size_t)15u;
}

static lsamp__v3 lsamp__piece_corner(const float *v, uint32_t i) { return lsamp__v3_load(v + 3u * (i % 3u)); }

/* Returns a vector along the normal of a triangle, of twice its area. */
static lsamp__v3 lsamp__cross_of(const float *v)
{
    lsamp__v3 a = lsamp__piece_corner(v, 0);
    return lsamp__v3_cross(lsamp__v3_sub(lsamp__piece_corner(v, 1), a),
                           lsamp__v3_sub(lsamp__piece_corner(v, 2), a));
}

static double lsamp__area_of(const float *v)
{
    double area = 0.5 * (double)lsamp__v3_length(lsamp__cross_of(v));
    return area > 0.0 && area < 1e30 ? area : 0.0;
}

static void lsamp__load_triangle(const lsamp_mesh *m, size_t t, float v[9])
{
    uint32_t scratch[3], k;
    const uint32_t *c = lsamp__corners(m, t, scratch);
    for (k = 0; k < 3; k++) lsamp__v3_store(v + 3u * k, lsamp__vertex(m, c[k]));
}

/* Halves a triangle across its longest edge `levels` times; the bits of number choose the halves. */
static void lsamp__cut_piece(float v[9], uint32_t levels, uint32_t number)
{
    uint32_t bit, i, edge, k;
    for (bit = 0; bit < levels; bit++) {
        float longest = -1.0f;
        for (edge = i = 0; i < 3u; i++) {
            lsamp__v3 d = lsamp__v3_sub(lsamp__piece_corner(v, i + 1u), lsamp__piece_corner(v, i));
            if (lsamp__v3_dot(d, d) > longest) {
                longest = lsamp__v3_dot(d, d);
                edge = i;
            }
        }
        i = (edge + 1u) % 3u;
        for (k = 0; k < 3u; k++) {
            float middle = 0.5f * (v[3u * edge + k] + v[3u * i + k]);
            v[3u * (number >> bit & 1u ? edge : i) + k] = middle;
        }
    }
}

/* Returns the place of a piece on the curve: pieces that face the same way lie together, so that the sides of
   a thin plate do not mix; among them runs a Hilbert curve. */
static uint64_t lsamp__piece_key(const lsamp__piece *p, lsamp__v3 low, float size, uint32_t number)
{
    float n[3], middle[3];
    uint32_t axis = 0, cell[3], k;
    memcpy(n, p->normal, sizeof n);
    for (k = 1; k < 3u; k++)
        if (fabsf(n[k]) > fabsf(n[axis])) axis = k;
    lsamp__v3_store(middle,
                    lsamp__v3_add(lsamp__v3_add(lsamp__piece_corner(p->v, 0), lsamp__piece_corner(p->v, 1)),
                                  lsamp__piece_corner(p->v, 2)));
    lsamp__v3_store(middle, lsamp__v3_sub(lsamp__v3_scale(lsamp__v3_load(middle), 1.0f / 3.0f), low));
    for (k = 0; k < 3u; k++) {
        float x = middle[k] / size * 1024.0f;
        cell[k] = x > 0.0f ? x < 1023.0f ? (uint32_t)x : 1023u : 0u;
    }
    return (uint64_t)(2u * axis + (n[axis] < 0.0f)) << 61 |
           (uint64_t)lsamp__hilbert_index(cell, 10, 3) << 31 | number;
}

/* Sorts pieces by key. Heap sort needs no memory and gives the same everywhere. */
static void lsamp__sort_pieces(lsamp__piece *p, size_t count)
{
    size_t built = count / 2, end = count, at, child;
    while (end > 1) {
        lsamp__piece moved;
        if (built > 0) {
            moved = p[--built];
        } else {
            moved = p[--end];
            p[end] = p[0];
        }
        for (at = built; (child = 2 * at + 1) < end; at = child) {
            if (child + 1 < end && p[child].key < p[child + 1].key) child++;
            if (p[child].key <= moved.key) break;
            p[at] = p[child];
        }
        p[at] = moved;
    }
}

static const lsamp__piece *lsamp__find_piece(const lsamp__curve *c, double x)
{
    size_t low = 0, high = c->count - 1u;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (c->pieces[middle].end > x) high = middle;
        else low = middle + 1;
    }
    return &c->pieces[low];
}

static void lsamp__curve_point(const lsamp__curve *c, const float x[3], float position[3], float normal[3],
                               float *area)
{
    const lsamp__piece *p = lsamp__find_piece(c, (double)x[0]);
    float root = sqrtf(x[1]);
    lsamp__v3 q = lsamp__v3_scale(lsamp__piece_corner(p->v, 0), 1.0f - root);
    q = lsamp__v3_madd(q, lsamp__piece_corner(p->v, 1), root * (1.0f - x[2]));
    lsamp__v3_store(position, lsamp__v3_madd(q, lsamp__piece_corner(p->v, 2), root * x[2]));
    memcpy(normal, p->normal, sizeof p->normal);
    *area = (float)c->area;
}

/* Returns the area of the triangles that emit, and writes their bounds. */
static double lsamp__survey_mesh(const lsamp_mesh *m, lsamp__v3 *low, float *size)
{
    lsamp__v3 high = lsamp__v3_make(-1e30f, -1e30f, -1e30f), d;
    size_t t, count = lsamp__triangle_count(m);
    double sum = 0.0;
    float v[9];
    uint32_t k;
    *low = lsamp__v3_make(1e30f, 1e30f, 1e30f);
    for (t = 0; t < count; t++) {
        double area;
        lsamp__load_triangle(m, t, v);
        area = lsamp__area_of(v);
        sum += area;
        for (k = 0; k < 3u && area > 0.0; k++) {
            *low = lsamp__v3_min(*low, lsamp__piece_corner(v, k));
            high = lsamp__v3_max(high, lsamp__piece_corner(v, k));
        }
    }
    d = lsamp__v3_sub(high, *low);
    *size = d.x > d.y ? d.x : d.y;
    if (d.z > *size) *size = d.z;
    return sum;
}

static void lsamp__curve_cut(lsamp__curve *c, const lsamp_mesh *m, double most, lsamp__v3 low, float size)
{
    size_t t, count = lsamp__triangle_count(m);
    for (t = 0; t < count; t++) {
        float v[9];
        double area;
        uint32_t levels = 0, i;
        lsamp__load_triangle(m, t, v);
        area = lsamp__area_of(v);
        if (!(area > 0.0)) continue;
        while (area > most) {
            area *= 0.5;
            levels++;
        }
        for (i = 0; i >> levels == 0; i++) {
            lsamp__piece *p = &c->pieces[c->count];
            memcpy(p->v, v, sizeof v);
            lsamp__cut_piece(p->v, levels, i);
            lsamp__v3_store(p->normal, lsamp__v3_normalize(lsamp__cross_of(v)));
            p->end = area;
            p->key = lsamp__piece_key(p, low, size, c->count);
            c->count++;
        }
    }
}

static lsamp_result lsamp__curve_build(const lsamp_light_desc *d, void *memory, lsamp__curve **out)
{
    lsamp__curve *c = (lsamp__curve *)memory;
    lsamp__v3 low;
    float size;
    double sum = 0.0;
    uint32_t i;
    c->pieces = (lsamp__piece *)(void *)((char *)memory + ((sizeof *c + 15u) & ~(size_t)15u));
    c->locations = (float *)(void *)(c->pieces + lsamp__most_pieces(d));
    c->places = lsamp__place_count(d);
    c->count = 0;
    c->area = lsamp__survey_mesh(d->mesh, &low, &size);
    if (!(c->area > 0.0 && size > 0.0f && lsamp__finite(size))) return LSAMP_ERR_INPUT;
    lsamp__curve_cut(c, d->mesh, c->area / (2.0 * (double)c->places), low, size);
    lsamp__sort_pieces(c->pieces, c->count);
    for (i = 0; i < c->count; i++) {
        sum += c->pieces[i].end;
        c->pieces[i].end = sum / c->area;
    }
    for (i = 0; i < c->places; i++) {
        const lsamp__piece *p = lsamp__find_piece(c, ((double)i + 0.5) / (double)c->places);
        lsamp__v3 q = lsamp__v3_add(lsamp__v3_add(lsamp__piece_corner(p->v, 0), lsamp__piece_corner(p->v, 1)),
                                    lsamp__piece_corner(p->v, 2));
        q = lsamp__v3_madd(lsamp__v3_scale(q, 1.0f / 3.0f), lsamp__v3_load(p->normal), d->radius);
        lsamp__v3_store(c->locations + 4u * (size_t)i, q);
        c->locations[4u * (size_t)i + 3u] = 1.0f;
    }
    *out = c;
    return LSAMP_OK;
}
