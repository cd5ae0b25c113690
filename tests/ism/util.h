/* util.h - meshes, views, sources and a counting allocator for the tests of ism.h. Include ism.h with its
   implementation and cmocka.h before. */
#ifndef ISM_UTIL_H
#define ISM_UTIL_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UTIL_PI 3.14159265358979

/* ---- meshes: triangles without indices ---- */

typedef struct soup { float p[3 * 3 * 4096]; size_t triangles; } soup;

static inline ism_mesh soup_mesh(const soup *s)
{
    ism_mesh m;
    memset(&m, 0, sizeof m);
    m.positions = s->p;
    m.vertex_count = 3 * s->triangles;
    return m;
}

/* The parallelogram a + s u + t v, 2 n^2 triangles; its normal is u x v. */
static inline void soup_quad(soup *s, const float a[3], const float u[3], const float v[3], int n)
{
    static const int corner[6][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 0 }, { 1, 1 }, { 0, 1 } };
    int x, y, c, k;
    for (y = 0; y < n; y++)
        for (x = 0; x < n; x++)
            for (c = 0; c < 6; c++) {
                float *to = s->p + 9 * s->triangles + 3 * (c % 3);
                for (k = 0; k < 3; k++)
                    to[k] = a[k] + u[k] * (float)(x + corner[c][0]) / (float)n +
                            v[k] * (float)(y + corner[c][1]) / (float)n;
                s->triangles += (size_t)(c % 3 == 2);
            }
}

/* An axis-parallel box, its faces seen from inside (sign -1) or outside (1). */
static inline void soup_box(soup *s, const float lo[3], const float hi[3], int sign, int n)
{
    int axis, side;
    for (axis = 0; axis < 3; axis++)
        for (side = 0; side < 2; side++) {
            int b = (axis + 1) % 3, c = (axis + 2) % 3, swap = (side == 0) == (sign > 0);
            float a[3], u[3] = { 0, 0, 0 }, v[3] = { 0, 0, 0 };
            memcpy(a, lo, sizeof a);
            a[axis] = side ? hi[axis] : lo[axis];
            u[b] = hi[b] - lo[b];
            v[c] = hi[c] - lo[c];
            if (swap) soup_quad(s, a, v, u, n);
            else soup_quad(s, a, u, v, n);
        }
}

static inline void soup_octahedron(soup *s, float r)
{
    int t, k, c;
    for (t = 0; t < 8; t++)
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++) s->p[9 * s->triangles + (size_t)(3 * k + c)] = 0;
    for (t = 0; t < 8; t++, s->triangles++)
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++) s->p[9 * s->triangles + (size_t)(3 * k + c)] = c == k ? (t >> c & 1 ? -r : r) : 0;
}

/* ---- lists of VPLs, sources and receivers ---- */

static inline ism_vpl util_vpl(float x, float y, float z, float nx, float ny, float nz, float flux)
{
    ism_vpl v;
    memset(&v, 0, sizeof v);
    v.position[0] = x;
    v.position[1] = y;
    v.position[2] = z;
    v.normal[0] = v.axis[0] = nx;
    v.normal[1] = v.axis[1] = ny;
    v.normal[2] = v.axis[2] = nz;
    v.exponent = 1;
    v.flux[0] = v.flux[1] = v.flux[2] = flux;
    return v;
}

typedef struct grid { float p[3 * 65536], n[3 * 65536], f[3 * 65536]; uint32_t w, h; } grid;

/* Points of a rectangle with one normal, at cell centres. */
static inline void grid_fill(grid *g, uint32_t w, uint32_t h, const float a[3], const float u[3], const float v[3],
                             const float normal[3], float flux)
{
    uint32_t x, y;
    int k;
    g->w = w;
    g->h = h;
    for (y = 0; y < h; y++)
        for (x = 0; x < w; x++)
            for (k = 0; k < 3; k++) {
                size_t i = 3 * ((size_t)y * w + x) + (size_t)k;
                g->p[i] = a[k] + u[k] * ((float)x + 0.5f) / (float)w + v[k] * ((float)y + 0.5f) / (float)h;
                g->n[i] = normal[k];
                g->f[i] = flux;
            }
}

static inline ism_points grid_view(const grid *g)
{
    ism_points v;
    memset(&v, 0, sizeof v);
    v.positions = g->p;
    v.normals = g->n;
    v.count = (size_t)g->w * g->h;
    v.width = g->w;
    return v;
}

static inline ism_source grid_source(const grid *g)
{
    ism_source s;
    memset(&s, 0, sizeof s);
    s.width = g->w;
    s.height = g->h;
    s.positions = g->p;
    s.normals = g->n;
    s.fluxes = g->f;
    return s;
}

/* ---- what maps hold ---- */

static inline ism_stats util_stats(const ism_maps *maps)
{
    ism_info info;
    ism_get_info(maps, &info);
    return info.stats;
}

static inline void util_bounds(const ism_maps *maps, float center[3], float *radius)
{
    ism_info info;
    ism_get_info(maps, &info);
    memcpy(center, info.center, sizeof info.center);
    *radius = info.radius;
}

/* Of packed receivers with these geometric normals. */
static inline ism_result util_visible(const ism_maps *maps, uint32_t vpl, const float *positions, const float *normals,
                                      size_t count, float bias, float *visible)
{
    ism_points points;
    memset(&points, 0, sizeof points);
    points.count = count;
    points.positions = positions;
    points.normals = normals;
    return ism_visible(maps, vpl, &points, bias, visible);
}

/* ---- an allocator that counts, fails on demand, and fills what it gives and takes ---- */

typedef struct ledger { size_t live, calls, now, peak; long fail_at; int from_then_on; } ledger;

static inline void *ledger_alloc(size_t size, void *user)
{
    ledger *l = (ledger *)user;
    size_t *block;
    long call = (long)l->calls++;
    if (l->fail_at >= 0 && (call == l->fail_at || (l->from_then_on && call > l->fail_at))) return NULL;
    block = (size_t *)malloc(size + 8);
    if (!block) return NULL;
    block[0] = size;
    memset((char *)block + 8, 0xa5, size);
    l->live++;
    l->now += size;
    if (l->now > l->peak) l->peak = l->now;
    return (char *)block + 8;
}

static inline void ledger_free(void *memory, void *user)
{
    ledger *l = (ledger *)user;
    size_t *block = (size_t *)(void *)((char *)memory - 8);
    l->live--;
    l->now -= block[0];
    memset(memory, 0x5a, block[0]);
    free(block);
}

static inline ism_allocator ledger_allocator(ledger *l)
{
    ism_allocator a;
    memset(l, 0, sizeof *l);
    l->fail_at = -1;
    a.alloc_fn = ledger_alloc;
    a.free_fn = ledger_free;
    a.user = l;
    return a;
}

static inline uint32_t util_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static inline float util_unit(uint32_t *state) { return (float)(util_next(state) & 0xffffu) / 65536.0f; }

/* Runs tasks in an order that no program would choose. */
static inline void backwards(void *user, size_t count, ism_task task, void *context)
{
    size_t i;
    (void)user;
    for (i = count; i-- > 0;) task(context, i);
}

#ifdef ISM_IMPLEMENTATION
/* The form factor from a point at the origin to a flat quadrilateral, 0 if it is seen from behind. */
static inline float util_form_factor(const float normal[3], const float corners[12])
{
    ism__v3 c[4];
    float f;
    int k;
    for (k = 0; k < 4; k++) c[k] = ism__v3_load(corners + 3 * k);
    f = ism__form_factor(ism__v3_load(normal), c, 4, NULL);
    return f > 0 ? f : 0;
}
#endif

#endif
