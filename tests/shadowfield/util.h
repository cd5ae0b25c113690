/* util.h - what the tests of shadowfield.h share: meshes, random numbers, an allocator that counts and fails on
   demand. Include shadowfield.h with its implementation before. */
#ifndef SFIELD_UTIL_H
#define SFIELD_UTIL_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Receivers as a literal: count positions and normals. */
#define AT(p, n, number) &(const sfield_points){ .count = (number), .positions = (p), .normals = (n) }

#define PI 3.14159265358979323846
#define UNUSED_OK static inline

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
UNUSED_OK float rnd_in(uint64_t *s, double lo, double hi) { return (float)(lo + (hi - lo) * rnd(s)); }

UNUSED_OK void rnd_direction(uint64_t *s, double *d)
{
    double z = 2 * rnd(s) - 1, phi = 2 * PI * rnd(s), r = sqrt(1 - z * z);
    d[0] = r * cos(phi);
    d[1] = r * sin(phi);
    d[2] = z;
}

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

UNUSED_OK sfield_mesh mesh_of(const model *m)
{
    sfield_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = m->p;
    mesh.vertex_count = m->vertices;
    mesh.indices = m->i;
    mesh.index_count = m->indices;
    return mesh;
}

/* Latitude-longitude sphere of u columns and v rows about the origin, seen counter-clockwise from outside. */
UNUSED_OK model model_sphere(uint32_t u, uint32_t v, double radius)
{
    model m = model_alloc((size_t)u * (v - 1) + 2, (size_t)2 * u * (v - 1));
    uint32_t x, y, *i = m.i, top = u * (v - 1), bottom = top + 1;
    for (y = 1; y < v; y++)
        for (x = 0; x < u; x++) {
            double t = PI * y / v, p = 2 * PI * x / u;
            float *q = m.p + 3 * ((size_t)(y - 1) * u + x);
            q[0] = (float)(radius * sin(t) * cos(p));
            q[1] = (float)(radius * cos(t));
            q[2] = (float)(radius * sin(t) * sin(p));
        }
    m.p[3 * top + 1] = (float)radius;
    m.p[3 * bottom + 1] = (float)-radius;
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

/* Axis-aligned box. */
UNUSED_OK model model_box(double x, double y, double z)
{
    static const uint8_t quad[6][4] = { { 1, 3, 7, 5 }, { 0, 4, 6, 2 }, { 2, 6, 7, 3 }, { 0, 1, 5, 4 }, { 4, 5, 7, 6 },
                                        { 0, 2, 3, 1 } };
    model m = model_alloc(8, 12);
    uint32_t *i = m.i, f, c;
    for (c = 0; c < 8; c++) {
        m.p[3 * c] = (float)(c & 1 ? x : -x);
        m.p[3 * c + 1] = (float)(c & 2 ? y : -y);
        m.p[3 * c + 2] = (float)(c & 4 ? z : -z);
    }
    for (f = 0; f < 6; f++) {
        *i++ = quad[f][0]; *i++ = quad[f][1]; *i++ = quad[f][2];
        *i++ = quad[f][0]; *i++ = quad[f][2]; *i++ = quad[f][3];
    }
    return m;
}

/* Triangles of any kind: an open soup in the unit ball. */
UNUSED_OK model model_soup(uint32_t triangles, double size, uint64_t seed)
{
    model m = model_alloc((size_t)3 * triangles, triangles);
    uint32_t t, k, c;
    for (t = 0; t < triangles; t++) {
        double at[3];
        for (c = 0; c < 3; c++) at[c] = rnd(&seed) - 0.5;
        for (k = 0; k < 3; k++) {
            for (c = 0; c < 3; c++) m.p[3 * (3 * t + k) + c] = (float)(at[c] + (2 * rnd(&seed) - 1) * size);
            m.i[3 * t + k] = 3 * t + k;
        }
    }
    return m;
}

/* Rotation by the quaternion's rule, times scale, then moved. */
UNUSED_OK void matrix_of(float *m, double ax, double ay, double az, double angle, double scale, double tx, double ty,
                         double tz)
{
    double l = sqrt(ax * ax + ay * ay + az * az), s = sin(angle / 2), w = cos(angle / 2);
    double x = l > 0 ? ax / l * s : 0, y = l > 0 ? ay / l * s : 0, z = l > 0 ? az / l * s : 0;
    memset(m, 0, 16 * sizeof *m);
    m[0] = (float)(scale * (1 - 2 * (y * y + z * z)));
    m[1] = (float)(scale * 2 * (x * y + w * z));
    m[2] = (float)(scale * 2 * (x * z - w * y));
    m[4] = (float)(scale * 2 * (x * y - w * z));
    m[5] = (float)(scale * (1 - 2 * (x * x + z * z)));
    m[6] = (float)(scale * 2 * (y * z + w * x));
    m[8] = (float)(scale * 2 * (x * z + w * y));
    m[9] = (float)(scale * 2 * (y * z - w * x));
    m[10] = (float)(scale * (1 - 2 * (x * x + y * y)));
    m[12] = (float)tx;
    m[13] = (float)ty;
    m[14] = (float)tz;
    m[15] = 1;
}

UNUSED_OK void turn(const float *m, const double *d, double *out)
{
    int k;
    for (k = 0; k < 3; k++) out[k] = (double)m[k] * d[0] + (double)m[4 + k] * d[1] + (double)m[8 + k] * d[2];
}

/* Value of a function of n bands in a direction. */
UNUSED_OK double sh_value(uint32_t bands, const float *c, const double *d)
{
    double y[SFIELD_MAX_COEFS], sum = 0;
    uint32_t k;
    sfield_sh_basis(bands, d, y);
    for (k = 0; k < bands * bands; k++) sum += (double)c[k] * y[k];
    return sum;
}

typedef struct counting { size_t now, peak, calls, fail_at; int forever; } counting;

UNUSED_OK void *counting_alloc(size_t size, void *user)
{
    counting *c = (counting *)user;
    size_t *p;
    c->calls++;
    if (c->fail_at && (c->forever ? c->calls >= c->fail_at : c->calls == c->fail_at)) return NULL;
    p = (size_t *)malloc(size + 8);
    if (!p) return NULL;
    p[0] = size;
    c->now += size;
    c->peak = c->now > c->peak ? c->now : c->peak;
    return (char *)p + 8;
}

UNUSED_OK void counting_free(void *memory, void *user)
{
    counting *c = (counting *)user;
    char *p = (char *)memory - 8;
    size_t size;
    memcpy(&size, p, sizeof size);
    c->now -= size;
    free(p);
}

UNUSED_OK sfield_allocator counting_allocator(counting *c)
{
    sfield_allocator a;
    a.alloc_fn = counting_alloc;
    a.free_fn = counting_free;
    a.user = c;
    return a;
}

/* A small field of a mesh: 4 shells from 0.5 r to 8 r with 6 x 4 x 4 points unless set. */
UNUSED_OK sfield_desc small_desc(sfield_basis basis)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.basis = basis;
    d.shell_count = 4;
    d.position_side = 4;
    d.cube_side = 8;
    d.inner = 0.5f;
    d.outer = 8;
    d.keep = 0.2f;
    return d;
}

/* Share of the sphere of directions that a unit sphere hides from d away. */
UNUSED_OK double blocked(double d) { return 0.5 * (1 - sqrt(1 - 1 / (d * d))); }

UNUSED_OK sfield_field *field_of_sphere(const sfield_desc *from)
{
    model m = model_sphere(64, 32, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc desc = *from;
    sfield_field *field = NULL;
    desc.radius = 1;
    desc.position_side = 3;                     /* a sphere looks the same from everywhere */
    if (sfield_build(&desc, &mesh, &field, NULL) != SFIELD_OK) abort();
    model_free(&m);
    return field;
}

#endif
