/* util.h - what the tests of csm.h share: meshes, a ray caster in double precision, threads, an allocator that
   counts and fails on demand. Include csm.h with its implementation before. */
#ifndef CSM_UTIL_H
#define CSM_UTIL_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define UNUSED_OK static inline

/* ---- random numbers ---- */

UNUSED_OK uint32_t rnd_u32(uint64_t *s)
{
    uint64_t z;
    *s += 0x9e3779b97f4a7c15u;
    z = *s;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (uint32_t)((z ^ z >> 31) >> 32);
}

UNUSED_OK uint32_t rnd_below(uint64_t *s, uint32_t n) { return (uint32_t)((uint64_t)rnd_u32(s) * n >> 32); }
UNUSED_OK double rnd(uint64_t *s) { return (double)rnd_u32(s) / 4294967296.0; }
UNUSED_OK double rnd_in(uint64_t *s, double lo, double hi) { return lo + (hi - lo) * rnd(s); }

UNUSED_OK void rnd_direction(uint64_t *s, float *d)
{
    double z = rnd_in(s, -1, 1), phi = rnd_in(s, 0, 2 * PI), r = sqrt(1 - z * z);
    d[0] = (float)(r * cos(phi));
    d[1] = (float)z;
    d[2] = (float)(r * sin(phi));
}

/* ---- meshes ---- */

typedef struct model {
    float    *p;
    uint32_t *i;
    size_t    vertices, indices;
} model;

UNUSED_OK model model_alloc(size_t vertices, size_t triangles)
{
    model m;
    m.p = (float *)calloc(3 * vertices + 1, sizeof(float));
    m.i = (uint32_t *)calloc(3 * triangles + 1, sizeof(uint32_t));
    m.vertices = vertices;
    m.indices = 3 * triangles;
    if (!m.p || !m.i) abort();
    return m;
}

UNUSED_OK void model_free(model *m)
{
    free(m->p);
    free(m->i);
    m->p = NULL;
    m->i = NULL;
}

UNUSED_OK cohsm_mesh mesh_of(const model *m)
{
    cohsm_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = m->p;
    mesh.vertex_count = m->vertices;
    mesh.indices = m->i;
    mesh.index_count = m->indices;
    return mesh;
}

/* Latitude-longitude sphere of u columns and v rows, radius 1 + bump: closed. */
UNUSED_OK model model_sphere(uint32_t u, uint32_t v, double bump)
{
    model m = model_alloc((size_t)u * (v - 1) + 2, (size_t)2 * u * (v - 1));
    uint32_t x, y, *i = m.i, top = u * (v - 1), bottom = top + 1;
    for (y = 1; y < v; y++)
        for (x = 0; x < u; x++) {
            double t = PI * y / v, p = 2 * PI * x / u, r = 1 + bump * sin(3 * t) * cos(5 * p) * sin(t);
            float *q = m.p + 3 * ((size_t)(y - 1) * u + x);
            q[0] = (float)(r * sin(t) * cos(p));
            q[1] = (float)(r * cos(t));
            q[2] = (float)(r * sin(t) * sin(p));
        }
    m.p[3 * top + 1] = 1;
    m.p[3 * bottom + 1] = -1;
    for (x = 0; x < u; x++) {
        uint32_t n = (x + 1) % u;
        *i++ = top; *i++ = n; *i++ = x;
        *i++ = bottom; *i++ = (v - 2) * u + x; *i++ = (v - 2) * u + n;
        for (y = 0; y + 2 < v; y++) {
            *i++ = y * u + x; *i++ = y * u + n; *i++ = (y + 1) * u + x;
            *i++ = y * u + n; *i++ = (y + 1) * u + n; *i++ = (y + 1) * u + x;
        }
    }
    return m;
}

UNUSED_OK model model_torus(uint32_t u, uint32_t v, double big, double small)
{
    model m = model_alloc((size_t)u * v, (size_t)2 * u * v);
    uint32_t x, y, *i = m.i;
    for (y = 0; y < v; y++)
        for (x = 0; x < u; x++) {
            double a = 2 * PI * x / u, b = 2 * PI * y / v, r = big + small * cos(b);
            float *q = m.p + 3 * ((size_t)y * u + x);
            uint32_t x1 = (x + 1) % u, y1 = (y + 1) % v;
            q[0] = (float)(r * cos(a));
            q[1] = (float)(small * sin(b));
            q[2] = (float)(r * sin(a));
            *i++ = y * u + x; *i++ = y1 * u + x; *i++ = y * u + x1;
            *i++ = y * u + x1; *i++ = y1 * u + x; *i++ = y1 * u + x1;
        }
    return m;
}

/* Axis-aligned box; left = bits of faces to leave out (0..5: +X -X +Y -Y +Z -Z). */
UNUSED_OK model model_box(const double *lo, const double *hi, unsigned left)
{
    static const uint8_t quad[6][4] = { { 1, 3, 7, 5 }, { 0, 4, 6, 2 }, { 2, 6, 7, 3 }, { 0, 1, 5, 4 }, { 4, 5, 7, 6 },
                                        { 0, 2, 3, 1 } };
    model m = model_alloc(8, 12);
    uint32_t *i = m.i, f, c;
    for (c = 0; c < 8; c++)
        for (f = 0; f < 3; f++) m.p[3 * c + f] = (float)(c >> f & 1u ? hi[f] : lo[f]);
    for (f = 0; f < 6; f++) {
        if (left >> f & 1u) continue;
        *i++ = quad[f][0]; *i++ = quad[f][1]; *i++ = quad[f][2];
        *i++ = quad[f][0]; *i++ = quad[f][2]; *i++ = quad[f][3];
    }
    m.indices = (size_t)(i - m.i);
    return m;
}

UNUSED_OK model model_cube(double half, unsigned left)
{
    double lo[3], hi[3];
    lo[0] = lo[1] = lo[2] = -half;
    hi[0] = hi[1] = hi[2] = half;
    return model_box(lo, hi, left);
}

/* Triangles of any kind: an open soup in the unit ball. */
UNUSED_OK model model_soup(uint32_t triangles, double size, uint64_t seed)
{
    model m = model_alloc((size_t)3 * triangles, triangles);
    uint32_t t, k, c;
    for (t = 0; t < triangles; t++) {
        double at[3];
        for (c = 0; c < 3; c++) at[c] = rnd_in(&seed, -0.5, 0.5);
        for (k = 0; k < 3; k++) {
            for (c = 0; c < 3; c++) m.p[3 * (3 * t + k) + c] = (float)(at[c] + rnd_in(&seed, -size, size));
            m.i[3 * t + k] = 3 * t + k;
        }
    }
    return m;
}

UNUSED_OK model model_join(const model *a, const model *b)
{
    model m = model_alloc(a->vertices + b->vertices, (a->indices + b->indices) / 3);
    size_t i;
    memcpy(m.p, a->p, 12 * a->vertices);
    memcpy(m.p + 3 * a->vertices, b->p, 12 * b->vertices);
    memcpy(m.i, a->i, 4 * a->indices);
    for (i = 0; i < b->indices; i++) m.i[a->indices + i] = b->i[i] + (uint32_t)a->vertices;
    return m;
}

/* A room with walls of some thickness: what lies between a ray's first and second hit counts as inside of the object,
   so that walls without thickness would not do. left_out = bits of walls, as for a box. */
UNUSED_OK model model_room(const double *lo, const double *hi, double wall, unsigned left_out)
{
    model m = model_alloc(0, 0);
    int f, c;
    for (f = 0; f < 6; f++) {
        double a[3], b[3];
        model slab, both;
        if (left_out >> f & 1u) continue;
        for (c = 0; c < 3; c++) {
            a[c] = lo[c] - wall;
            b[c] = hi[c] + wall;
        }
        if (f & 1) b[f / 2] = lo[f / 2];
        else a[f / 2] = hi[f / 2];
        slab = model_box(a, b, 0);
        both = model_join(&m, &slab);
        model_free(&m);
        model_free(&slab);
        m = both;
    }
    return m;
}

/* ---- rays, in double ---- */

#define NO_HIT (-1e300)

/* Distance along direction d from o of the hit with triangle t, or NO_HIT. */
UNUSED_OK double ray_triangle(const model *m, size_t t, const double *o, const double *d)
{
    const float *a = m->p + 3 * m->i[3 * t], *b = m->p + 3 * m->i[3 * t + 1], *c = m->p + 3 * m->i[3 * t + 2];
    double e1[3], e2[3], s[3], pv[3], qv[3], det, u, v;
    int k;
    for (k = 0; k < 3; k++) {
        e1[k] = (double)b[k] - (double)a[k];
        e2[k] = (double)c[k] - (double)a[k];
        s[k] = o[k] - (double)a[k];
    }
    for (k = 0; k < 3; k++) pv[k] = d[(k + 1) % 3] * e2[(k + 2) % 3] - d[(k + 2) % 3] * e2[(k + 1) % 3];
    det = e1[0] * pv[0] + e1[1] * pv[1] + e1[2] * pv[2];
    if (fabs(det) < 1e-300) return NO_HIT;
    u = (s[0] * pv[0] + s[1] * pv[1] + s[2] * pv[2]) / det;
    if (u < 0 || u > 1) return NO_HIT;
    for (k = 0; k < 3; k++) qv[k] = s[(k + 1) % 3] * e1[(k + 2) % 3] - s[(k + 2) % 3] * e1[(k + 1) % 3];
    v = (d[0] * qv[0] + d[1] * qv[1] + d[2] * qv[2]) / det;
    if (v < 0 || u + v > 1) return NO_HIT;
    return (e2[0] * qv[0] + e2[1] * qv[1] + e2[2] * qv[2]) / det;
}

/* The nearest hits beyond `from`, sorted; returns how many of room. */
UNUSED_OK int ray_hits(const model *m, const double *o, const double *d, double from, double *hits, int room)
{
    size_t t, count = m->indices / 3;
    int n = 0, i;
    for (t = 0; t < count; t++) {
        double h = ray_triangle(m, t, o, d);
        if (!(h > from)) continue;
        for (i = n < room ? n++ : room; i > 0 && hits[i - 1] > h; i--)
            if (i < room) hits[i] = hits[i - 1];
        if (i < room) hits[i] = h;
    }
    return n;
}

/* ---- threads: a parallel-for that takes the tasks from the last to the first ---- */

#ifndef CSM_NO_THREADS
#include <pthread.h>

typedef struct team { int threads; pthread_mutex_t lock; size_t next, count; cohsm_task task; void *context; } team;

UNUSED_OK void *team_work(void *p)
{
    team *t = (team *)p;
    for (;;) {
        size_t i;
        pthread_mutex_lock(&t->lock);
        i = t->next++;
        pthread_mutex_unlock(&t->lock);
        if (i >= t->count) return NULL;
        t->task(t->context, t->count - 1 - i);
    }
}

UNUSED_OK void team_for(void *user, size_t count, cohsm_task task, void *context)
{
    team *t = (team *)user;
    pthread_t id[16];
    int i, made = 0;
    t->next = 0;
    t->count = count;
    t->task = task;
    t->context = context;
    for (i = 0; i + 1 < t->threads; i++)
        if (pthread_create(&id[made], NULL, team_work, t) == 0) made++;
    team_work(t);
    for (i = 0; i < made; i++) pthread_join(id[i], NULL);
}
#endif

/* ---- an allocator that counts, and fails when it is told to ---- */

typedef struct ledger {
    size_t live, used, peak, calls, wrong;
    size_t fail_at;         /* 0 = never; else the number of the call that fails */
    int    from_then_on;
} ledger;

/* Eight bytes past what malloc gives: not aligned to 16, as malloc itself on 32-bit systems. */
UNUSED_OK void *ledger_alloc(size_t size, void *user)
{
    ledger *l = (ledger *)user;
    char *p;
    l->calls++;
    if (l->fail_at && (l->calls == l->fail_at || (l->from_then_on && l->calls > l->fail_at))) return NULL;
    if (size == 0) l->wrong++;
    p = (char *)malloc(size + 8);
    if (!p) return NULL;
    memcpy(p, &size, sizeof size);
    memset(p + 8, 0xa5, size);         /* what is not initialised shows */
    l->live++;
    l->used += size;
    if (l->used > l->peak) l->peak = l->used;
    return p + 8;
}

UNUSED_OK void ledger_free(void *memory, void *user)
{
    ledger *l = (ledger *)user;
    char *p = (char *)memory - 8;
    size_t size;
    if (!memory) {
        l->wrong++;
        return;
    }
    memcpy(&size, p, sizeof size);
    l->live--;
    l->used -= size;
    memset(memory, 0xdd, size);
    free(p);
}

UNUSED_OK cohsm_allocator ledger_allocator(ledger *l)
{
    cohsm_allocator a;
    memset(l, 0, sizeof *l);
    a.alloc_fn = ledger_alloc;
    a.free_fn = ledger_free;
    a.user = l;
    return a;
}

/* ---- descs ---- */

UNUSED_OK cohsm_desc desc_of(cohsm_domain_kind kind, uint32_t side, uint32_t size)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.domain.kind = kind;
    d.domain.side[0] = side;
    if (kind != COHSM_DOMAIN_LINE) d.domain.side[1] = side;
    if (kind == COHSM_DOMAIN_VOLUME) d.domain.side[2] = side;
    d.map_side = size;
    return d;
}

/* A local domain above the unit sphere. */
UNUSED_OK void place_domain(cohsm_desc *d, float x, float y, float z, float extent)
{
    d->domain.origin[0] = x;
    d->domain.origin[1] = y;
    d->domain.origin[2] = z;
    d->domain.u[0] = extent;
    d->domain.v[2] = extent;
    d->domain.w[1] = extent;
}

/* Every domain, order and frame. */
static const struct {
    cohsm_domain_kind domain;
    uint32_t side;
    cohsm_order order;
    cohsm_orientation orientation;
} csm_kinds[] = {
    { COHSM_DOMAIN_LATLONG, 24, COHSM_ORDER_SCANLINE, COHSM_ORIENTATION_MINIMAL },
    { COHSM_DOMAIN_LATLONG, 20, COHSM_ORDER_ZIGZAG, COHSM_ORIENTATION_TWO_POLES },
    { COHSM_DOMAIN_LATLONG, 17, COHSM_ORDER_ZIGZAG_THETA, COHSM_ORIENTATION_POLAR },
    { COHSM_DOMAIN_LATLONG, 32, COHSM_ORDER_HILBERT, COHSM_ORIENTATION_POLAR },
    { COHSM_DOMAIN_OCTAHEDRAL, 16, COHSM_ORDER_HILBERT, COHSM_ORIENTATION_POLAR },
    { COHSM_DOMAIN_OCTAHEDRAL, 16, COHSM_ORDER_ZIGZAG, COHSM_ORIENTATION_TWO_POLES },
    { COHSM_DOMAIN_LINE, 9, COHSM_ORDER_DEFAULT, COHSM_ORIENTATION_DEFAULT },
    { COHSM_DOMAIN_RECTANGLE, 6, COHSM_ORDER_HILBERT, COHSM_ORIENTATION_DEFAULT },
    { COHSM_DOMAIN_DISC, 6, COHSM_ORDER_ZIGZAG_THETA, COHSM_ORIENTATION_DEFAULT },
    { COHSM_DOMAIN_SPHERE, 6, COHSM_ORDER_ZIGZAG, COHSM_ORIENTATION_DEFAULT },
    { COHSM_DOMAIN_VOLUME, 3, COHSM_ORDER_HILBERT, COHSM_ORIENTATION_DEFAULT }
};

/* Layers as they come: from no segment of its own in pixels of the first column to one for almost every view in those
   of the last, with depths that are exact where the layers lie close together. */
static inline cohsm_maps *torture_maps(cohsm_layout layout)
{
    enum { SIDE = 33, M = 16 };
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, SIDE, M);
    cohsm_builder *b = NULL;
    cohsm_maps *maps = NULL;
    float z1[M * M], z2[M * M];
    uint64_t seed = 31;
    uint32_t i, p;

    d.radius = 1;
    d.order = COHSM_ORDER_SCANLINE;
    d.layout = layout;
    if (cohsm_builder_create(&d, &b) != COHSM_OK) abort();
    for (i = 0; i < cohsm_builder_view_count(b); i++) {
        for (p = 0; p < M * M; p++) {
            int wild = rnd_below(&seed, 256) < (p % M) * (p % M);
            z1[p] = wild ? (float)rnd_in(&seed, 0.1, 0.9) : 0.5f + 0.01f * (float)(p % 7);
            z2[p] = z1[p] + (p % 4 == 1 ? 1e-5f : 0.02f);
        }
        if (cohsm_builder_add(b, i, z1, z2, z2) != COHSM_OK) abort();
    }
    if (cohsm_builder_finish(b, &maps, NULL) != COHSM_OK) abort();
    cohsm_builder_free(b);
    return maps;
}

#endif
