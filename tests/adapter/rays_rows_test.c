/* rays_rows_test - the rows of rows.c by rays: a renderer of one page that knows none of Dapple's headers, with every
   triangle tried for every ray. So the rows can be run by something else, and what they expect is not Dapple's own. */
#ifdef ADAPTER_ALONE                    /* linked with rows.c, as a renderer of one's own is: tests/scripts/docs.sh */
#include "adapter.h"
#include <math.h>
#include <string.h>
#define ROW_PI 3.14159265358979323846
#else
#define CONFORM_BACKEND "rays"          /* tools/conformance leaves the page to the others */
#include "rows.c"
#endif

static adapter_scene scene;

const char *adapter_name(void) { return "rays"; }

int adapter_open(const adapter_scene *opened)
{
    scene = *opened;
    return 1;
}

void adapter_close(void) { memset(&scene, 0, sizeof scene); }

typedef struct vec { double x, y, z; } vec;

static vec v3(double x, double y, double z)
{
    vec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
static vec load(const float *p) { return v3((double)p[0], (double)p[1], (double)p[2]); }
static vec along(vec p, vec d, double t) { return v3(p.x + t * d.x, p.y + t * d.y, p.z + t * d.z); }
static vec from_to(vec a, vec b) { return along(b, a, -1); }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static vec unit(vec a)
{
    const double s = 1 / sqrt(dot(a, a));
    return v3(s * a.x, s * a.y, s * a.z);
}

/* Two unit vectors that make a right-handed frame with n. */
static void frame_of(vec n, vec *a, vec *b)
{
    *a = unit(cross(fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0), n));
    *b = cross(n, *a);
}

/* The nearest hit beyond 1e-6 and before `most`, in lengths of d; -1 if there is none. Moeller and Trumbore 1997. */
static double trace(vec p, vec d, double most, size_t *triangle)
{
    double best = most;
    size_t k;
    for (k = 0; k < scene.triangle_count; k++) {
        const uint32_t *i = scene.indices + 3 * k;
        const vec a = load(scene.positions + 3 * i[0]), e1 = from_to(a, load(scene.positions + 3 * i[1])),
                  e2 = from_to(a, load(scene.positions + 3 * i[2])),
                  h = cross(d, e2), s = from_to(a, p), q = cross(s, e1);
        const double det = dot(e1, h), u = dot(s, h) / det, v = dot(d, q) / det, t = dot(e2, q) / det;
        if (!(fabs(det) > 1e-14) || u < 0 || v < 0 || u + v > 1 || t < 1e-6 || t >= best) continue;
        best = t;
        if (triangle) *triangle = k;
    }
    return best < most ? best : -1;
}

static int is_free(vec p, vec d, double most) { return trace(p, d, most, NULL) < 0; }

int adapter_visible(const float *positions, const float *ends, int at_infinity, size_t count, float *visible)
{
    size_t k;
    for (k = 0; k < count; k++) {
        const vec p = load(positions + 3 * k), e = load(ends + 3 * k);
        visible[k] = (float)is_free(p, at_infinity ? e : from_to(p, e), at_infinity ? 1e30 : 1);
    }
    return 1;
}

/* ---- light ---- */

/* Adds `share` of what the light sends from place q (radiance x area x its cosine, or intensity) to a point. */
static void add_place(const adapter_light *l, vec p, vec n, vec q, vec side, int has_side, double area, double rgb[3])
{
    const vec to = from_to(p, q);
    const double d2 = dot(to, to), cosine = dot(n, to) / sqrt(d2), from = has_side ? -dot(side, to) / sqrt(d2) : 1;
    int c;
    if (cosine <= 0 || from <= 0 || !is_free(p, to, 1 - 1e-9)) return;
    for (c = 0; c < 3; c++) rgb[c] += (double)l->value[c] * area * cosine * from / d2;
}

/* Adds what comes from a direction, of which the sky covers a solid angle. */
static void add_sky(const adapter_light *l, vec p, vec n, vec d, double omega, const float *factor, double rgb[3])
{
    const double cosine = dot(n, d);
    int c;
    if (cosine <= 0 || !is_free(p, d, 1e30)) return;
    for (c = 0; c < 3; c++) rgb[c] += (double)l->value[c] * (factor ? (double)factor[c] : 1) * cosine * omega;
}

static void light_by_sky(const adapter_light *l, vec p, vec n, double rgb[3])
{
    const uint32_t w = l->texels ? l->width : 72, h = l->texels ? l->height : 36;
    enum { FINE = 4 };                  /* each texel FINE x FINE times */
    uint32_t x, y;
    for (y = 0; y < FINE * h; y++) {
        const double t0 = ROW_PI * y / (FINE * h), t1 = ROW_PI * (y + 1) / (FINE * h), t = (t0 + t1) / 2;
        for (x = 0; x < FINE * w; x++) {
            const double f = 2 * ROW_PI * ((x + 0.5) / (FINE * w) - 0.5);
            const float *factor = l->texels ? l->texels + 3 * (y / FINE * w + x / FINE) : NULL;
            if (factor && factor[0] <= 0 && factor[1] <= 0 && factor[2] <= 0) continue;
            add_sky(l, p, n, v3(sin(t) * cos(f), cos(t), sin(t) * sin(f)),
                    (cos(t0) - cos(t1)) * 2 * ROW_PI / (FINE * w),
                    factor, rgb);
        }
    }
}

/* Lamps with an area, by a grid of places. */
static void light_by_area(const adapter_light *l, vec p, vec n, double rgb[3])
{
    enum { GRID = 100 };
    const vec at = load(l->position), u = load(l->u), v = load(l->v), facing = load(l->direction);
    vec a = u, b = v;
    int x, y;
    if (l->kind == ADAPTER_DISC) frame_of(facing, &a, &b);
    for (y = 0; y < GRID; y++)
        for (x = 0; x < GRID; x++) {
            const double s = (x + 0.5) / GRID, t = (y + 0.5) / GRID, r = (double)l->radius;
            if (l->kind == ADAPTER_RECTANGLE) {
                const vec side = cross(u, v);
                add_place(l, p, n, along(along(at, u, s), v, t), unit(side), 1,
                          sqrt(dot(side, side)) / (GRID * GRID), rgb);
            } else if (l->kind == ADAPTER_DISC) {
                const double f = 2 * ROW_PI * s, q = r * sqrt(t);
                add_place(l, p, n, along(along(at, a, q * cos(f)), b, q * sin(f)), facing, 1,
                          ROW_PI * r * r / (GRID * GRID), rgb);
            } else {
                const double f = 2 * ROW_PI * s, h = 1 - 2 * t, q = sqrt(1 - h * h);
                const vec side = v3(q * cos(f), h, q * sin(f));
                add_place(l, p, n, along(at, side, r), side, 1, 4 * ROW_PI * r * r / (GRID * GRID), rgb);
            }
        }
}

static void light_point(const adapter_light *l, vec p, vec n, double rgb[3])
{
    const vec none = { 0, 0, 0 };
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (l->kind == ADAPTER_SKY) light_by_sky(l, p, n, rgb);
    else if (l->kind == ADAPTER_SUN) add_sky(l, p, n, load(l->direction), 1, NULL, rgb);
    else if (l->kind > ADAPTER_SPOT) light_by_area(l, p, n, rgb);
    else if (l->kind == ADAPTER_POINT ||
             dot(unit(from_to(load(l->position), p)), load(l->direction)) >= cos((double)l->cone_half_angle))
        add_place(l, p, n, load(l->position), none, 0, 1, rgb);
}

int adapter_direct(const adapter_light *light, const float *positions, const float *normals, size_t count,
                   float *irradiance)
{
    double rgb[3];
    size_t k;
    int c;
    for (k = 0; k < count; k++) {
        light_point(light, load(positions + 3 * k), load(normals + 3 * k), rgb);
        for (c = 0; c < 3; c++) irradiance[3 * k + (size_t)c] = (float)rgb[c];
    }
    return 1;
}

/* Rays in proportion to the cosine, each of which brings what the place that it meets throws back. */
int adapter_bounced(const adapter_light *light, const float *positions, const float *normals, size_t count,
                    float *irradiance)
{
    const int rays = scene.triangle_count < 1000 ? 40000 : 4000;
    size_t k, hit = 0;
    int i, c;
    if (light->kind != ADAPTER_SUN && light->kind != ADAPTER_POINT) return 0;
    for (k = 0; k < count; k++) {
        const vec p = load(positions + 3 * k), n = load(normals + 3 * k);
        double sum[3] = { 0, 0, 0 }, rgb[3];
        vec a, b;
        frame_of(n, &a, &b);
        for (i = 0; i < rays; i++) {
            const double f = 2.39996322972865332 * i, s = (i + 0.5) / rays, r = sqrt(s);
            const vec d = along(along(along(v3(0, 0, 0), n, sqrt(1 - s)), a, r * cos(f)), b, r * sin(f));
            const double t = trace(p, d, 1e30, &hit);
            const uint32_t *at = scene.indices + 3 * hit;
            vec m, q;
            if (t < 0) continue;
            q = load(scene.positions + 3 * at[0]);
            m = unit(cross(from_to(q, load(scene.positions + 3 * at[1])),
                           from_to(q, load(scene.positions + 3 * at[2]))));
            if (dot(m, d) > 0) m = v3(-m.x, -m.y, -m.z);
            light_point(light, along(p, d, t), m, rgb);
            for (c = 0; c < 3; c++) sum[c] += rgb[c] * (scene.albedos ? (double)scene.albedos[hit] : 0) / rays;
        }
        for (c = 0; c < 3; c++) irradiance[3 * k + (size_t)c] = (float)sum[c];
    }
    return 1;
}
