/* sfield_scene.c - points, directions and errors for the benchmarks of shadowfield.h. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static float random_in(uint32_t *state)
{
    *state = *state * 747796405u + 2891336453u;
    return (float)(*state >> 8) / 16777216.0f;
}

/* Edges u, v of a triangle, its unit normal, and twice its area. */
static double triangle(const ex_mesh *mesh, size_t t, const float **corner, float u[3], float v[3], float n[3])
{
    const uint32_t *i = mesh->indices + 3 * t;
    const float *b = mesh->positions + 3 * (size_t)i[1], *c = mesh->positions + 3 * (size_t)i[2];
    float length;
    *corner = mesh->positions + 3 * (size_t)i[0];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - (*corner)[k];
        v[k] = c[k] - (*corner)[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        n[k] /= length > 0 ? length : 1;
    return (double)length;
}

typedef struct spread_point { uint32_t place; float p[3], n[3]; } spread_point;

static int by_place(const void *a, const void *b)
{
    const spread_point *x = a, *y = b;
    return x->place != y->place ? (x->place > y->place) - (x->place < y->place) : memcmp(x, y, sizeof *x);
}

/* Along a Morton curve through the box of the mesh, so that neighbours in the array are neighbours in space. */
static void sort_points(spread_point *points, size_t count, const ex_mesh *mesh)
{
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, size = 0;
    for (size_t k = 0; k < 3; k++) {
        float high = -HUGE_VALF;
        for (size_t i = 0; i < mesh->vertex_count; i++) {
            low[k] = fminf(low[k], mesh->positions[3 * i + k]);
            high = fmaxf(high, mesh->positions[3 * i + k]);
        }
        size = fmaxf(size, high - low[k]);
    }
    for (size_t i = 0; i < count; i++) {
        points[i].place = 0;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t at = (uint32_t)fminf(fmaxf((points[i].p[k] - low[k]) / size * 1024, 0), 1023);
            for (uint32_t b = 0; b < 10; b++)
                points[i].place |= (at >> b & 1u) << (3 * b + k);
        }
    }
    qsort(points, count, sizeof *points, by_place);
}

int bn_points_spread(bn_points *points, const ex_mesh *mesh, size_t count)
{
    double total = 0, sum = 0;
    uint32_t seed = 1;
    size_t n = 0;
    const float *a;
    float u[3], v[3], normal[3];
    spread_point *spread = malloc(count * sizeof *spread);
    points->count = 0;
    points->positions = malloc(3 * count * sizeof *points->positions);
    points->normals = malloc(3 * count * sizeof *points->normals);
    if (!points->positions || !points->normals || !spread) {
        free(spread);
        return -1;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        total += triangle(mesh, t, &a, u, v, normal);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        sum += triangle(mesh, t, &a, u, v, normal);
        for (; n < count && ((double)n + 0.5) * total < sum * (double)count; n++) {
            float p = sqrtf(random_in(&seed)), q = random_in(&seed) * p;
            for (size_t k = 0; k < 3; k++) {
                spread[n].p[k] = a[k] + u[k] * (p - q) + v[k] * q;
                spread[n].n[k] = normal[k];
            }
        }
    }
    sort_points(spread, n, mesh);
    for (; points->count < n; points->count++) {
        memcpy(points->positions + 3 * points->count, spread[points->count].p, sizeof spread->p);
        memcpy(points->normals + 3 * points->count, spread[points->count].n, sizeof spread->n);
    }
    free(spread);
    return 0;
}

void bn_points_free(bn_points *points)
{
    free(points->positions);
    free(points->normals);
    memset(points, 0, sizeof *points);
}

void bn_points_world(const bn_points *points, size_t i, const float m[16], float p[3], float n[3])
{
    const float *a = points->positions + 3 * i, *b = points->normals + 3 * i;
    float scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    for (int k = 0; k < 3; k++) {
        p[k] = m[k] * a[0] + m[4 + k] * a[1] + m[8 + k] * a[2] + m[12 + k];
        n[k] = (m[k] * b[0] + m[4 + k] * b[1] + m[8 + k] * b[2]) / scale;
    }
}

void bn_cap_direction(const float z[3], float cap, int i, int n, float direction[3])
{
    float s = z[2] >= 0 ? 1.0f : -1.0f, a = -1 / (s + z[2]), b = z[0] * z[1] * a;
    float x[3] = { 1 + s * z[0] * z[0] * a, s * b, -s * z[0] }, y[3] = { b, s + z[1] * z[1] * a, -z[1] };
    float up = 1 - cap * ((float)i + 0.5f) / (float)n, r = sqrtf(fmaxf(1 - up * up, 0)), phi = 2.39996323f * (float)i;
    for (int k = 0; k < 3; k++)
        direction[k] = up * z[k] + r * (cosf(phi) * x[k] + sinf(phi) * y[k]);
}

void bn_error_add(bn_error *error, double value, double truth)
{
    error->square += (value - truth) * (value - truth);
    error->sum += truth;
    error->count++;
}

double bn_error_relative(const bn_error *error)
{
    return error->count ? sqrt(error->square * (double)error->count) / error->sum : (double)NAN;
}

sfield_desc bn_sfield_desc(const bn_options *options)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    return d;
}
