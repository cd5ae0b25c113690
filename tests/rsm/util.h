/* util.h - what the tests of rsm.h share: a counting allocator, small scenes, shorthands. */
#ifndef RSM_UTIL_H
#define RSM_UTIL_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ledger.h"

#if defined(__GNUC__)
#define UNUSED_OK __attribute__((unused)) static
#else
#define UNUSED_OK static
#endif

#define PI 3.14159265358979323846

/* ---- a system that counts ---- */

UNUSED_OK rsm_system ledger_system(ledger *l)
{
    rsm_system s;
    memset(l, 0, sizeof *l);
    memset(&s, 0, sizeof s);
    s.allocator.alloc_fn = ledger_alloc;
    s.allocator.free_fn = ledger_free;
    s.allocator.user = l;
    return s;
}

/* ---- scenes ---- */

UNUSED_OK void set3(float *p, double x, double y, double z)
{
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

typedef struct model { float *p; uint32_t *i; size_t vertices, indices; } model;

UNUSED_OK void model_free(model *m)
{
    free(m->p);
    free(m->i);
    m->p = NULL;
    m->i = NULL;
}

/* A fan of `sides` about the origin in the plane y = 0, radius r. */
UNUSED_OK model model_disc(uint32_t sides, double r)
{
    model m;
    uint32_t k;
    m.vertices = sides + 1;
    m.indices = 3 * (size_t)sides;
    m.p = (float *)calloc(3 * m.vertices, sizeof *m.p);
    m.i = (uint32_t *)calloc(m.indices, sizeof *m.i);
    for (k = 0; k < sides; k++) {
        set3(m.p + 3 * k, r * cos(2 * PI * k / sides), 0, r * sin(2 * PI * k / sides));
        m.i[3 * k] = sides;
        m.i[3 * k + 1] = (k + 1) % sides;
        m.i[3 * k + 2] = k;
    }
    return m;
}

/* Parallelograms: corner, edge, edge, nine numbers each. */
UNUSED_OK model model_quads(const float *q, uint32_t count)
{
    static const uint32_t order[6] = { 0, 1, 2, 0, 2, 3 };
    model m;
    uint32_t k, c;
    m.vertices = 4 * (size_t)count;
    m.indices = 6 * (size_t)count;
    m.p = (float *)calloc(3 * m.vertices, sizeof *m.p);
    m.i = (uint32_t *)calloc(m.indices, sizeof *m.i);
    for (k = 0; k < count; k++, q += 9) {
        for (c = 0; c < 3; c++) {
            m.p[12 * k + c] = q[c];
            m.p[12 * k + 3 + c] = q[c] + q[3 + c];
            m.p[12 * k + 6 + c] = q[c] + q[3 + c] + q[6 + c];
            m.p[12 * k + 9 + c] = q[c] + q[6 + c];
        }
        for (c = 0; c < 6; c++) m.i[6 * k + c] = 4 * k + order[c];
    }
    return m;
}

UNUSED_OK rsm_mesh mesh_of(const model *m, double albedo)
{
    rsm_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = m->p;
    mesh.vertex_count = m->vertices;
    mesh.indices = m->i;
    mesh.index_count = m->indices;
    set3(mesh.albedo, albedo, albedo, albedo);
    return mesh;
}

/* Sun straight down of irradiance e over a square of half side r. */
UNUSED_OK rsm_desc sun_desc(double e, double r, uint32_t size)
{
    rsm_desc d;
    memset(&d, 0, sizeof d);
    d.light.kind = RSM_LIGHT_SUN;
    d.light.direction[1] = 1;
    set3(d.light.value, e, e, e);
    d.light.radius = (float)r;
    d.side = size;
    return d;
}

/* Map of meshes, finished; NULL on failure. */
UNUSED_OK rsm_map *map_of(const rsm_desc *desc, const rsm_mesh *meshes, size_t count, rsm_stats *stats)
{
    rsm_map *map;
    if (rsm_map_create(desc, &map) != RSM_OK) return NULL;
    if (rsm_rasterize(map, meshes, count) == RSM_OK && rsm_finish(map, stats) == RSM_OK) return map;
    rsm_map_free(map);
    return NULL;
}

UNUSED_OK rsm_points points_of(const float *positions, const float *normals, size_t count, uint32_t width)
{
    rsm_points p;
    memset(&p, 0, sizeof p);
    p.count = count;
    p.positions = positions;
    p.normals = normals;
    p.width = width;
    return p;
}

/* Irradiance at one point, first channel; < 0 on failure. */
UNUSED_OK double gather_at(const rsm_map *map, const rsm_gather_desc *desc, double x, double y, double z, double nx,
                           double ny, double nz)
{
    float p[3], n[3], e[3];
    rsm_points points;
    set3(p, x, y, z);
    set3(n, nx, ny, nz);
    points = points_of(p, n, 1, 0);
    return rsm_gather(&map, 1, desc, &points, e, NULL) == RSM_OK ? (double)e[0] : -1.0;
}

UNUSED_OK rsm_gather_desc gather_desc(rsm_pattern pattern, uint32_t samples)
{
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.pattern = pattern;
    d.sample_count = samples;
    return d;
}

/* What zeros stand for, spelled out for those who reckon with it. */
UNUSED_OK rsm_direct_desc direct_desc(void)
{
    rsm_direct_desc d;
    memset(&d, 0, sizeof d);
    d.tap_side = 2;
    d.bias = 0.5f;
    d.slope_bias = 1;
    return d;
}

UNUSED_OK uint32_t map_side(const rsm_map *map)
{
    rsm_info info = { 0 };
    rsm_get_info(map, &info);
    return info.side;
}

UNUSED_OK uint32_t map_faces(const rsm_map *map)
{
    rsm_info info = { 0 };
    rsm_get_info(map, &info);
    return info.face_count;
}

#endif
