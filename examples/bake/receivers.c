/* receivers.c - see receive.h: vertices, or texels of UV sets without overlaps. A texel belongs to the triangle that
   holds its centre; of two triangles that share an edge through a centre one has it, by the rule that rasterisers have.
 */
#include "receive.h"
#include "bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NOBODY UINT32_MAX
enum { MOST_SIDE = 8192 };

typedef struct painter {             /* the sheet that is being painted */
    uint32_t  side;
    uint32_t *triangle, *primitive;  /* of each texel, or NOBODY */
    float    *weight;                /* of its triangle's second and third corner */
    size_t    covered, twice;        /* texels that have one, and that a second one wanted */
} painter;

typedef struct making {
    bk_receivers *out;
    const bk_primitives *all;
    bk_into  into;
    painter  paint;
    size_t   room;
    char    *error;
} making;

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "out of memory: fewer texels may do");
    return -1;
}

/* ---- texels ---- */

/* Is a point on the edge from a to b inside? Of the two directions of an edge one is. */
static int edge_counts(const double *a, const double *b)
{
    return a[1] > b[1] || (!(a[1] < b[1]) && a[0] < b[0]);
}

static double side_of(const double *a, const double *b, const double *p)
{
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* Weights of the corners at p, which sum up to 1; returns 0 outside. */
static int inside(double q[3][2], double area, const double *p, double *weight)
{
    for (int k = 0; k < 3; k++) {
        const double *a = q[(k + 1) % 3], *b = q[(k + 2) % 3], s = side_of(a, b, p);
        weight[k] = s / area;
        if (weight[k] < 0 || (!(weight[k] > 0) && edge_counts(a, b) != (area > 0)))
            return 0;
    }
    return 1;
}

static void paint_texel(painter *m, size_t at, uint32_t primitive, uint32_t triangle, const double *weight)
{
    if (m->triangle[at] != NOBODY) {
        m->twice++;
        return;
    }
    m->triangle[at] = triangle;
    m->primitive[at] = primitive;
    m->weight[2 * at] = (float)weight[1];
    m->weight[2 * at + 1] = (float)weight[2];
    m->covered++;
}

/* Corners of a triangle in texels; 0 where they lie outside of the image. */
static int corners_of(const bk_primitive *p, int uv, uint32_t side, size_t triangle, double q[3][2])
{
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 2; k++) {
            const double x = (double)p->uvs[uv][2 * (size_t)p->indices[3 * triangle + (size_t)c] + (size_t)k];
            if (!(x > -1e-3 && x < 1.001))
                return 0;
            q[c][k] = x * side;
        }
    return 1;
}

/* Where a row of texel centres crosses the triangle, widened by rounding; returns 0 where it does not. */
static int span_of(double q[3][2], double y, uint32_t side, double *from, double *to)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        const double *a = q[k], *b = q[(k + 1) % 3];
        const double t = (y - a[1]) / (b[1] - a[1]), x = a[0] + t * (b[0] - a[0]);
        if (!(fabs(b[1] - a[1]) > 1e-12) || t < -1e-9 || t > 1 + 1e-9)
            continue;
        low = fmin(low, x);
        high = fmax(high, x);
    }
    if (!(high >= low))
        return 0;
    *from = fmax(0, floor(low - 0.5) - 1);
    *to = fmin(side - 1.0, ceil(high - 0.5) + 1);
    return 1;
}

/* Paints a primitive's triangles; returns 0 if they leave the image, cover each other too much, or most of them have no
   area in it. */
static int paint_primitive(painter *m, const bk_primitives *all, uint32_t number, int uv)
{
    const bk_primitive *p = &all->list[number];
    uint32_t flat = 0;
    for (uint32_t t = 0; t < p->triangle_count; t++) {
        double q[3][2], weight[3], low, high, first, last, area;
        if (!corners_of(p, uv, m->side, t, q))
            return 0;
        area = side_of(q[0], q[1], q[2]);
        if (!(fabs(area) > 1e-12)) {
            flat++;
            continue;
        }
        low = fmax(0, floor(fmin(q[0][1], fmin(q[1][1], q[2][1])) - 0.5));
        high = fmin(m->side - 1.0, ceil(fmax(q[0][1], fmax(q[1][1], q[2][1]))));
        for (double y = low; y <= high; y++)
            if (span_of(q, y + 0.5, m->side, &first, &last))
                for (double x = first; x <= last; x++) {
                    const double center[2] = { x + 0.5, y + 0.5 };
                    if (inside(q, area, center, weight))
                        paint_texel(m, (size_t)y * m->side + (size_t)x, number, t, weight);
                }
        if (m->twice > (size_t)m->side * m->side / 100)
            return 0;
    }
    return flat <= p->triangle_count / 2;
}

/* Takes back what the last primitive has painted. */
static void unpaint(painter *m, uint32_t number)
{
    const size_t texels = (size_t)m->side * m->side;
    for (size_t i = 0; i < texels; i++)
        if (m->primitive[i] == number && m->triangle[i] != NOBODY) {
            m->triangle[i] = NOBODY;
            m->covered--;
        }
    m->twice = 0;
}

/* Does the primitive fit into the image, beside what is there? If so it is painted. One texel in a hundred may overlap:
   charts touch. */
static int fits(making *m, uint32_t number, int uv)
{
    painter *paint = &m->paint;
    const size_t before = paint->covered;
    int good;
    if (!m->all->list[number].uvs[uv])
        return 0;
    paint->twice = 0;
    good = paint_primitive(paint, m->all, number, uv) && paint->twice <= (paint->covered - before) / 100;
    if (!good)
        unpaint(paint, number);
    return good;
}

/* ---- receivers ---- */

static int grow(making *m, size_t count)
{
    bk_receivers *r = m->out;
    float *p, *n;
    uint32_t *w;
    if (r->count + count <= m->room)
        return 0;
    m->room = 2 * (r->count + count);
    if (20.0 * (double)m->room > 8.0 * (double)ex_memory_limit)
        return -1;
    p = realloc(r->positions, 12 * m->room);
    r->positions = p ? p : r->positions;
    n = realloc(r->normals, 12 * m->room);
    r->normals = n ? n : r->normals;
    w = realloc(r->places, 4 * m->room);
    r->places = w ? w : r->places;
    return p && n && w ? 0 : -1;
}

static void add(making *m, const float *position, const float *normal, uint32_t place)
{
    bk_receivers *r = m->out;
    float length = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int k = 0; k < 3; k++) {
        r->positions[3 * r->count + (size_t)k] = position[k];
        r->normals[3 * r->count + (size_t)k] = length > 1e-20f ? normal[k] / length : k == 1 ? 1.0f : 0.0f;
    }
    r->places[r->count++] = place;
}

static int add_vertices(making *m, const bk_primitive *p)
{
    if (grow(m, p->vertex_count) != 0)
        return -1;
    for (uint32_t v = 0; v < p->vertex_count; v++)
        if (p->used[v])
            add(m, p->positions + 3 * (size_t)v, p->normals + 3 * (size_t)v, v);
    return 0;
}

static int add_texels(making *m)
{
    const painter *paint = &m->paint;
    const size_t texels = (size_t)paint->side * paint->side;
    if (grow(m, paint->covered) != 0)
        return -1;
    for (size_t i = 0; i < texels; i++) {
        const bk_primitive *p;
        const uint32_t *index;
        float position[3], normal[3], w[3];
        if (paint->triangle[i] == NOBODY)
            continue;
        p = &m->all->list[paint->primitive[i]];
        index = p->indices + 3 * (size_t)paint->triangle[i];
        w[1] = paint->weight[2 * i];
        w[2] = paint->weight[2 * i + 1];
        w[0] = 1 - w[1] - w[2];
        for (int k = 0; k < 3; k++) {
            position[k] = normal[k] = 0;
            for (int c = 0; c < 3; c++) {
                position[k] += w[c] * p->positions[3 * (size_t)index[c] + (size_t)k];
                normal[k] += w[c] * p->normals[3 * (size_t)index[c] + (size_t)k];
            }
        }
        add(m, position, normal, (uint32_t)i);
    }
    return 0;
}

/* ---- along a curve ---- */

typedef struct key { uint32_t code, index; } key;

static uint32_t spread(uint32_t x)       /* ten bits, two zeros behind each */
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

static int by_code(const void *a, const void *b)
{
    const key *x = a, *y = b;
    if (x->code != y->code)
        return x->code < y->code ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

/* Place on Morton's curve. */
static uint32_t code_of(const float *p, const float *low, float scale)
{
    uint32_t code = 0;
    for (int k = 0; k < 3; k++) {
        const float x = (p[k] - low[k]) * scale;
        code |= spread(x > 0 ? x < 1023 ? (uint32_t)x : 1023 : 0) << k;
    }
    return code;
}

static int sort_sheet(bk_receivers *r, const bk_sheet *s)
{
    float *p = r->positions + 3 * s->first, *n = r->normals + 3 * s->first, low[3], extent = 0;
    uint32_t *w = r->places + s->first;
    key *keys = malloc((s->count + 1) * sizeof *keys);
    float *old = malloc(28 * s->count + 1);
    if (!keys || !old || s->count > UINT32_MAX) {
        free(keys);
        free(old);
        return -1;
    }
    for (int k = 0; k < 3; k++) {
        float high = -HUGE_VALF;
        low[k] = HUGE_VALF;
        for (size_t i = 0; i < s->count; i++) {
            low[k] = fminf(low[k], p[3 * i + (size_t)k]);
            high = fmaxf(high, p[3 * i + (size_t)k]);
        }
        extent = fmaxf(extent, high - low[k]);
    }
    for (size_t i = 0; i < s->count; i++) {
        keys[i].code = code_of(p + 3 * i, low, extent > 0 ? 1023 / extent : 0);
        keys[i].index = (uint32_t)i;
    }
    qsort(keys, s->count, sizeof *keys, by_code);
    memcpy(old, p, 12 * s->count);
    memcpy(old + 3 * s->count, n, 12 * s->count);
    memcpy(old + 6 * s->count, w, 4 * s->count);
    for (size_t i = 0; i < s->count; i++) {
        memcpy(p + 3 * i, old + 3 * (size_t)keys[i].index, 12);
        memcpy(n + 3 * i, old + 3 * (s->count + keys[i].index), 12);
        memcpy(w + i, old + 6 * s->count + keys[i].index, 4);
    }
    free(keys);
    free(old);
    return 0;
}

/* ---- sheets ---- */

static bk_sheet *new_sheet(making *m, uint32_t mesh)
{
    bk_receivers *r = m->out;
    bk_sheet *grown = realloc(r->sheets, (r->sheet_count + (size_t)1) * sizeof *grown);
    if (!grown)
        return NULL;
    r->sheets = grown;
    memset(&grown[r->sheet_count], 0, sizeof *grown);
    grown[r->sheet_count].mesh = mesh;
    grown[r->sheet_count].first = r->count;
    return &grown[r->sheet_count++];
}

static int join_sheet(bk_sheet *s, uint32_t primitive)
{
    uint32_t *grown = realloc(s->primitives, (s->primitive_count + (size_t)1) * sizeof *grown);
    if (!grown)
        return -1;
    s->primitives = grown;
    grown[s->primitive_count++] = primitive;
    return 0;
}

static int close_sheet(making *m, bk_sheet *s)
{
    s->count = m->out->count - s->first;
    return sort_sheet(m->out, s);
}

/* Images of a mesh: each takes the primitives that fit beside each other. Marks in `taken` what got one. */
static int make_images(making *m, uint32_t from, uint32_t to, uint8_t *taken)
{
    const size_t texels = (size_t)m->paint.side * m->paint.side;
    for (uint32_t i = from; i < to; i++)
        for (int uv = 1; uv >= 0 && !taken[i - from] && m->all->list[i].triangle_count; uv--) {
            bk_sheet *s;
            if (!m->all->list[i].uvs[uv])
                continue;
            memset(m->paint.triangle, 0xff, texels * sizeof *m->paint.triangle);
            m->paint.covered = 0;
            if (!fits(m, i, uv))
                continue;
            if (!(s = new_sheet(m, m->all->list[i].mesh)))
                return -1;
            s->side = m->paint.side;
            s->uv = uv;
            for (uint32_t k = i; k < to; k++)
                if (k == i || (!taken[k - from] && m->all->list[k].triangle_count && fits(m, k, uv))) {
                    taken[k - from] = 1;
                    if (join_sheet(s, k) != 0)
                        return -1;
                }
            if (add_texels(m) != 0 || close_sheet(m, s) != 0)
                return -1;
        }
    return 0;
}

/* Primitives of one mesh: images first, if they may be, then vertices. */
static int make_mesh(making *m, uint32_t from, uint32_t to)
{
    uint8_t *taken = calloc((size_t)(to - from) + 1, 1);
    int result = taken ? 0 : -1;
    if (result == 0 && m->into != BK_INTO_VERTEX)
        result = make_images(m, from, to, taken);
    for (uint32_t i = from; i < to && result == 0; i++) {
        const bk_primitive *p = &m->all->list[i];
        bk_sheet *s = NULL;
        if (taken[i - from] || !p->triangle_count)
            continue;
        if (m->into == BK_INTO_TEXTURE) {
            snprintf(m->error, EX_ERROR_SIZE, "mesh %u: primitive %u has no UV set without overlaps in 0..1",
                     (unsigned)p->mesh, (unsigned)p->number);
            free(taken);
            return -2;
        }
        if (!(s = new_sheet(m, p->mesh)))
            result = -1;
        for (uint32_t k = i; k < to && result == 0; k++)
            if (!taken[k - from] && m->all->list[k].owner == p->owner && m->all->list[k].triangle_count) {
                taken[k - from] = 1;
                result = join_sheet(s, k);
            }
        if (result == 0 && (add_vertices(m, p) != 0 || close_sheet(m, s) != 0))
            result = -1;
    }
    free(taken);
    return result;
}

static int make_paint(painter *paint, uint32_t side)
{
    const size_t texels = (size_t)side * side;
    paint->side = side;
    paint->triangle = malloc(texels * sizeof *paint->triangle);
    paint->primitive = malloc(texels * sizeof *paint->primitive);
    paint->weight = malloc(2 * texels * sizeof *paint->weight);
    return side <= MOST_SIDE && paint->triangle && paint->primitive && paint->weight ? 0 : -1;
}

int bk_receivers_make(bk_receivers *out, const bk_primitives *all, const uint8_t *wanted, uint32_t mesh_count,
                      bk_into into, uint32_t side, char *error)
{
    making m;
    int result = 0;
    memset(out, 0, sizeof *out);
    memset(&m, 0, sizeof m);
    m.out = out;
    m.all = all;
    m.into = into;
    m.error = error;
    if (into != BK_INTO_VERTEX)
        result = make_paint(&m.paint, side);
    for (uint32_t i = 0, next; i < all->count && result == 0; i = next) {
        for (next = i; next < all->count && all->list[next].mesh == all->list[i].mesh;)
            next++;
        if (all->list[i].mesh < mesh_count && wanted[all->list[i].mesh])
            result = make_mesh(&m, i, next);
    }
    free(m.paint.triangle);
    free(m.paint.primitive);
    free(m.paint.weight);
    if (result == 0 && !out->count)
        snprintf(error, EX_ERROR_SIZE, "nothing there has triangles");
    else if (result == -1)
        out_of_memory(error);
    if (result == 0 && out->count)
        return 0;
    bk_receivers_free(out);
    return -1;
}

void bk_receivers_free(bk_receivers *r)
{
    for (uint32_t i = 0; i < r->sheet_count; i++)
        free(r->sheets[i].primitives);
    free(r->sheets);
    free(r->positions);
    free(r->normals);
    free(r->places);
    memset(r, 0, sizeof *r);
}
