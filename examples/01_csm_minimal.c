/* 01_csm_minimal.c - soft shadows from coherent shadow maps, with csm.h and nothing else.

   cc -O2 01_csm_minimal.c -lm -o minimal && ./minimal shadow.ppm

   A torus floats above a floor under a round sky-light. Maps of 64 x 64 directions are built once for the torus; then
   every pixel asks them from which of 256 directions it is lit. */
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 200, RINGS = 96, SIDES = 48, SAMPLES = 256 };

static const float pi = 3.14159265f, major = 1.0f, minor = 0.4f, floor_y = -0.7f;

/* ---- the object: a mesh made by code, as plain arrays ---- */

static float    positions[RINGS * SIDES * 3];
static uint32_t indices[RINGS * SIDES * 6];

static cohsm_mesh make_torus(void)
{
    cohsm_mesh mesh = { positions, RINGS * SIDES, 0, indices, RINGS * SIDES * 6, NULL, NULL, NULL };
    uint32_t i, j, k = 0;
    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++) {
            float a = 2 * pi * (float)i / RINGS, b = 2 * pi * (float)j / SIDES, *p = positions + 3 * (i * SIDES + j);
            uint32_t i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            p[0] = (major + minor * cosf(b)) * cosf(a);
            p[1] = minor * sinf(b);
            p[2] = (major + minor * cosf(b)) * sinf(a);
            indices[k++] = i * SIDES + j, indices[k++] = i * SIDES + j2, indices[k++] = i2 * SIDES + j2;
            indices[k++] = i * SIDES + j, indices[k++] = i2 * SIDES + j2, indices[k++] = i2 * SIDES + j;
        }
    return mesh;
}

/* ---- what a renderer has anyway: which surface point a pixel shows ---- */

static float torus_distance(const float *p)
{
    float ring = sqrtf(p[0] * p[0] + p[2] * p[2]) - major;
    return sqrtf(ring * ring + p[1] * p[1]) - minor;
}

/* Walks along the pixel's ray; returns 0 for background. */
static int find_surface(int x, int y, float *p, float *n)
{
    float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, -0.15f - ((float)y + 0.5f) / HEIGHT, -1.2f }, t = 0;
    float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), ring;
    int i, step;
    for (step = 0; step < 400 && t < 30; step++) {
        float distance, above;
        for (i = 0; i < 3; i++) p[i] = t * d[i] / length;
        p[1] += 2.9f;
        p[2] += 5.2f;
        distance = torus_distance(p);
        above = p[1] - floor_y;
        if (distance < 1e-3f) {
            ring = sqrtf(p[0] * p[0] + p[2] * p[2]);
            n[0] = p[0] * (1 - major / ring) / minor;
            n[1] = p[1] / minor;
            n[2] = p[2] * (1 - major / ring) / minor;
            return 1;
        }
        if (above < 1e-3f) {
            n[0] = n[2] = 0;
            n[1] = 1;
            return 1;
        }
        t += distance < above ? distance : above;
    }
    return 0;
}

/* ---- shading ---- */

/* Directions spread evenly over a disc in the sky of 25 degrees radius, about a tilted axis. */
static void make_light(float *directions)
{
    const float axis[3] = { 0.48f, 0.80f, -0.36f }, u[3] = { 0.6f, 0, 0.8f }, v[3] = { -0.64f, 0.6f, 0.48f };
    int i, k;
    for (i = 0; i < SAMPLES; i++) {
        float r = 0.4663f * sqrtf(((float)i + 0.5f) / SAMPLES), phi = 2.39996323f * (float)i, *d = directions + 3 * i;
        float length = sqrtf(1 + r * r);
        for (k = 0; k < 3; k++) d[k] = (axis[k] + r * cosf(phi) * u[k] + r * sinf(phi) * v[k]) / length;
    }
}

/* Mean of visibility x cosine over the light. All samples of the pixel are one call. */
static float shade(const cohsm_maps *maps, const float *p, const float *n, const float *directions)
{
    float points[3 * SAMPLES], visible[SAMPLES], sum = 0;
    cohsm_query query = { 0 };
    int i, k;
    for (i = 0; i < SAMPLES; i++)
        for (k = 0; k < 3; k++) points[3 * i + k] = p[k] + 0.01f * n[k];
    query.positions = points;
    query.count = SAMPLES;
    query.lights = directions;
    if (cohsm_visible(maps, &query, visible, NULL) != COHSM_OK) return 0;
    for (i = 0; i < SAMPLES; i++) {
        const float *d = directions + 3 * i;
        float cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        if (cosine > 0) sum += visible[i] * cosine;
    }
    return sum / SAMPLES;
}

int main(int count, char **values)
{
    static float directions[3 * SAMPLES];
    cohsm_desc desc = { 0 };
    cohsm_mesh mesh = make_torus();
    cohsm_maps *maps;
    cohsm_info info;
    cohsm_result result;
    FILE *file = fopen(count > 1 ? values[1] : "shadow.ppm", "wb");
    int x, y;

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    desc.domain.side[0] = desc.domain.side[1] = 64;
    result = cohsm_build(&desc, &mesh, &maps, NULL);
    if (result != COHSM_OK) return fprintf(stderr, "%s\n", cohsm_result_text(result)), 1;
    cohsm_get_info(maps, &info);
    printf("%u maps in %.1f MB, %.0f times smaller\n", (unsigned)info.map_count, (double)info.bytes * 1e-6, info.ratio);

    make_light(directions);
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            float p[3], n[3], light = find_surface(x, y, p, n) ? 0.05f + 0.9f * shade(maps, p, n, directions) : 0.2f;
            int grey = (int)(255 * powf(light, 1 / 2.2f) + 0.5f);
            fputc(grey, file), fputc(grey, file), fputc(grey, file);
        }
    cohsm_free(maps);
    return fclose(file) != 0;
}
