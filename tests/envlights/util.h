/* util.h - what the tests of envlights.h share: maps, exact light by summing all texels, an allocator that counts and
   fails on demand. Include envlights.h before. */
#ifndef ENVLT_UTIL_H
#define ENVLT_UTIL_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "ledger.h"

#define PI 3.14159265358979323846
#define UNUSED_OK static inline
/* cmocka's own takes floats */
#define CLOSE(a, b, tolerance) assert_true(fabs((double)(a) - (double)(b)) <= (tolerance))

/* ---- random numbers ---- */

UNUSED_OK double rnd(uint64_t *s)
{
    uint64_t z;
    *s += 0x9e3779b97f4a7c15u;
    z = *s;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)(uint32_t)((z ^ z >> 31) >> 32) / 4294967296.0;
}

UNUSED_OK void rnd_direction(uint64_t *s, double *d)
{
    double z = 2 * rnd(s) - 1, phi = 2 * PI * rnd(s), r = sqrt(1 - z * z);
    d[0] = r * cos(phi);
    d[1] = z;
    d[2] = r * sin(phi);
}

/* ---- maps ---- */

typedef struct sky { envlt_map map; float *rgb; size_t texels; } sky;

UNUSED_OK sky sky_alloc(envlt_projection projection, uint32_t width, uint32_t height)
{
    sky s;
    memset(&s, 0, sizeof s);
    s.texels = (size_t)width * height * (projection == ENVLT_PROJECTION_CUBE ? 6 : 1);
    s.rgb = (float *)calloc(3 * s.texels, sizeof(float));
    if (!s.rgb) abort();
    s.map.projection = projection;
    s.map.width = width;
    s.map.height = height;
    s.map.rgb = s.rgb;
    return s;
}

UNUSED_OK void sky_free(sky *s)
{
    free(s->rgb);
    s->rgb = NULL;
}

UNUSED_OK void sky_texel(const sky *s, size_t t, double *d, double *omega)
{
    uint32_t w = s->map.width, h = s->map.height, x = (uint32_t)(t % w), y = (uint32_t)(t / w % h);
    float f[3];
    int c;
    envlt_texel_direction(s->map.projection, w, h, (uint32_t)(t / w / h), (float)x + 0.5f, (float)y + 0.5f, f);
    for (c = 0; c < 3; c++) d[c] = (double)f[c];
    *omega = envlt_texel_solid_angle(s->map.projection, w, h, x, y);
}

typedef void (*sky_fn)(const double *d, double *rgb);

UNUSED_OK void sky_fill(sky *s, sky_fn fn)
{
    size_t t;
    int c;
    for (t = 0; t < s->texels; t++) {
        double d[3], omega, rgb[3];
        sky_texel(s, t, d, &omega);
        fn(d, rgb);
        for (c = 0; c < 3; c++) s->rgb[3 * t + (size_t)c] = (float)rgb[c];
    }
}

UNUSED_OK double lobe(const double *d, double x, double y, double z, double sharpness)
{
    double l = sqrt(x * x + y * y + z * z);
    return exp(sharpness * ((d[0] * x + d[1] * y + d[2] * z) / l - 1));
}

/* A clear day: a small sun of most of the energy, a bluish dome that brightens to the horizon, brown ground. */
UNUSED_OK void sunny(const double *d, double *rgb)
{
    double sun = 2000 * (lobe(d, 0.5, 0.7, 0.4, 1) > 0.9992), glow = lobe(d, 0.5, 0.7, 0.4, 20);
    double up = d[1] > 0 ? d[1] : 0;
    rgb[0] = d[1] < 0 ? 0.18 : 0.25 + 0.2 * (1 - up) + 0.8 * glow + sun;
    rgb[1] = d[1] < 0 ? 0.15 : 0.35 + 0.2 * (1 - up) + 0.6 * glow + 0.9 * sun;
    rgb[2] = d[1] < 0 ? 0.12 : 0.60 + 0.1 * (1 - up) + 0.4 * glow + 0.7 * sun;
}

/* A dark room with three soft lamps of different colours and sizes and a strip. */
UNUSED_OK void studio(const double *d, double *rgb)
{
    double key = 9 * (d[0] > 0.6 && fabs(d[1] - 0.6 * d[0]) < 0.3 * d[0] && fabs(d[2]) < 0.35 * d[0]);
    double fill = 2 * lobe(d, -0.8, 0.3, 0.5, 12), top = 4 * (d[1] > 0.93);
    double strip = 8 * (fabs(d[2] + 0.8) < 0.2 && fabs(d[0] - 0.2 + 0.2 * d[1]) < 0.06);
    double wall = 0.02 + 0.02 * (d[1] + 1);
    rgb[0] = wall + key + 0.7 * fill + top + strip;
    rgb[1] = wall + 0.9 * key + 0.8 * fill + top + strip;
    rgb[2] = wall + 0.75 * key + fill + top + 1.1 * strip;
}

UNUSED_OK void even(const double *d, double *rgb)
{
    (void)d;
    rgb[0] = rgb[1] = rgb[2] = 1;
}

/* ---- error of lights under sharp visibility ----
   A receiver with normal n under a shadow edge: only directions in front of the planes a and b reach it. Relative RMSE
   of the luminance over many such receivers, against the sum over all texels. */
typedef struct receivers { size_t count; double n[256][3], a[256][3], b[256][3], exact[256]; } receivers;

UNUSED_OK double seen(const receivers *r, size_t i, const double *d, int shadows)
{
    double c = r->n[i][0] * d[0] + r->n[i][1] * d[1] + r->n[i][2] * d[2];
    if (!(c > 0)) return 0;
    if (shadows && r->a[i][0] * d[0] + r->a[i][1] * d[1] + r->a[i][2] * d[2] < -0.3) return 0;
    if (shadows && r->b[i][0] * d[0] + r->b[i][1] * d[1] + r->b[i][2] * d[2] < -0.3) return 0;
    return c;
}

UNUSED_OK void receivers_make(receivers *r, const sky *s, size_t count, int shadows)
{
    uint64_t seed = 7;
    size_t i, t;
    r->count = count;
    for (i = 0; i < count; i++) {
        rnd_direction(&seed, r->n[i]);
        rnd_direction(&seed, r->a[i]);
        rnd_direction(&seed, r->b[i]);
        r->exact[i] = 0;
    }
    for (t = 0; t < s->texels; t++) {
        const float *p = s->rgb + 3 * t;
        double d[3], omega, l = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        sky_texel(s, t, d, &omega);
        for (i = 0; i < count; i++) r->exact[i] += l * omega * seen(r, i, d, shadows);
    }
}

UNUSED_OK double receivers_error(const receivers *r, const envlt_light *lights, uint32_t k, int shadows)
{
    double square = 0, mean = 0;
    size_t i;
    uint32_t j;
    for (i = 0; i < r->count; i++) {
        double sum = 0;
        for (j = 0; j < k; j++) {
            const float *e = lights[j].irradiance;
            double d[3], l = 0.2126 * (double)e[0] + 0.7152 * (double)e[1] + 0.0722 * (double)e[2];
            d[0] = (double)lights[j].direction[0];
            d[1] = (double)lights[j].direction[1];
            d[2] = (double)lights[j].direction[2];
            sum += l * seen(r, i, d, shadows);
        }
        square += (sum - r->exact[i]) * (sum - r->exact[i]);
        mean += r->exact[i];
    }
    return sqrt(square / (double)r->count) / (mean / (double)r->count);
}

/* ---- lights ---- */

UNUSED_OK envlt_desc desc_of(envlt_method method, uint32_t k)
{
    envlt_desc d;
    memset(&d, 0, sizeof d);
    d.method = method;
    d.light_count = k;
    return d;
}

UNUSED_OK int light_is_finite(const envlt_light *l)
{
    double u = 0, v = 0, d = 0;
    int c, finite = 1;
    for (c = 0; c < 3; c++) {
        finite = finite && isfinite(l->direction[c]) && isfinite(l->irradiance[c]);
        d += (double)l->direction[c] * (double)l->direction[c];
        u += (double)l->axis_u[c] * (double)l->axis_u[c];
        v += (double)l->axis_v[c] * (double)l->axis_v[c];
    }
    return finite && fabs(sqrt(d) - 1) < 1e-3 && u < 1e6 && v < 1e6;
}

/* ---- memory ---- */

UNUSED_OK envlt_allocator ledger_allocator(ledger *l)
{
    envlt_allocator a;
    memset(l, 0, sizeof *l);
    a.alloc_fn = ledger_alloc;
    a.free_fn = ledger_free;
    a.user = l;
    return a;
}

#endif
