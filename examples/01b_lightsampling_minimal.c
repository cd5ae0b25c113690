/* 01b_lightsampling_minimal.c - a lamp and a sky on shiny spheres, with lightsampling.h and nothing else.

   cc -O2 01b_lightsampling_minimal.c -lm -o minimal && ./minimal light.ppm

   Three spheres of different materials stand on a floor under a square lamp and a pale sky. For every pixel the header
   draws directions to each of the two lights and weighs them; this program answers by a ray through the spheres which
   of them are free, as any renderer would by its own rays or shadow maps. */
#define LIGHTSAMPLING_IMPLEMENTATION
#include "lightsampling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 200, SAMPLES = 64, SPHERES = 3, SKY_WIDTH = 16, SKY_HEIGHT = 8 };

/* ---- what a renderer has anyway: surfaces, materials, rays ---- */

static const float center[SPHERES][3] = { { -1.5f, 0.6f, 0 }, { 0, 0.6f, 0.4f }, { 1.5f, 0.6f, 0 } }, radius = 0.6f;

/* Distance along a ray with unit direction d to the nearest sphere, whose number is written; -1: none. */
static float trace(const float *p, const float *d, int *which)
{
    float best = -1;
    int i;
    for (i = 0; i < SPHERES; i++) {
        const float *c = center[i];
        float v[3] = { p[0] - c[0], p[1] - c[1], p[2] - c[2] }, b = v[0] * d[0] + v[1] * d[1] + v[2] * d[2], t;
        float root = b * b - (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - radius * radius);
        if (root < 0) continue;
        t = -b - sqrtf(root);
        if (t > 1e-3f && (best < 0 || t < best)) {
            best = t;
            *which = i;
        }
    }
    return best;
}

/* The surface point that a pixel shows: position, normal, direction to the eye, material. Returns 0 for background. */
static int find_surface(int x, int y, float *p, float *n, float *view, int *material)
{
    static const float eye[3] = { 0, 2.2f, 5.2f };
    float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, 0.15f - ((float)y + 0.5f) / HEIGHT, -1.2f }, t;
    float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    int k;
    for (k = 0; k < 3; k++) d[k] /= length;
    t = trace(eye, d, material);
    if (t < 0) {
        if (d[1] >= 0) return 0;
        t = -eye[1] / d[1];
        *material = SPHERES;                    /* the floor */
    }
    for (k = 0; k < 3; k++) {
        p[k] = eye[k] + t * d[k];
        n[k] = *material == SPHERES ? k == 1 : (p[k] - center[*material][k]) / radius;
        view[k] = -d[k];
    }
    return 1;
}

/* A clay one, a plastic one, a metal one, and the floor. */
static void make_materials(lsamp_material *m)
{
    static const float colors[SPHERES + 1][3] = { { 0.8f, 0.4f, 0.3f }, { 0.1f, 0.3f, 0.6f }, { 0.9f, 0.7f, 0.3f },
                                                  { 0.5f, 0.5f, 0.5f } };
    int i;
    memset(m, 0, (SPHERES + 1) * sizeof *m);
    for (i = 0; i <= SPHERES; i++) memcpy(m[i].diffuse, colors[i], sizeof colors[i]);
    m[1].kind = LSAMP_MATERIAL_PHONG;
    m[1].specular[0] = m[1].specular[1] = m[1].specular[2] = 0.3f;
    m[1].exponent = 60;
    m[2].kind = LSAMP_MATERIAL_METAL_ROUGH;
    m[2].metallic = 1;
    m[2].roughness = 0.3f;
}

/* ---- lights ---- */

/* Builds a light in memory of its own; stops the program where it cannot. */
static lsamp_light *make_light(const lsamp_light_desc *desc)
{
    size_t bytes = lsamp_light_bytes(desc);
    void *memory = bytes ? malloc(bytes) : NULL;
    lsamp_light *light;
    lsamp_result result = lsamp_light_init(desc, memory, bytes, &light, NULL);
    if (result == LSAMP_OK) return light;
    fprintf(stderr, "%s\n", lsamp_result_text(result));
    exit(1);
}

static lsamp_light *make_lamp(void)
{
    lsamp_light_desc lamp;
    memset(&lamp, 0, sizeof lamp);
    lamp.kind = LSAMP_LIGHT_RECTANGLE;         /* a corner and two edges; it shines along u x v: down */
    lamp.position[0] = -2.5f, lamp.position[1] = 3, lamp.position[2] = -1;
    lamp.u[0] = 1.5f;
    lamp.v[2] = 1.5f;
    lamp.radiance[0] = 7, lamp.radiance[1] = 6, lamp.radiance[2] = 4;
    return make_light(&lamp);
}

/* A latitude-longitude map: blue above, nothing below the horizon. The header copies it. */
static lsamp_light *make_sky(void)
{
    static float texels[SKY_HEIGHT][SKY_WIDTH][3];
    lsamp_light_desc sky;
    int x, y;
    for (y = 0; y < SKY_HEIGHT / 2; y++)
        for (x = 0; x < SKY_WIDTH; x++) texels[y][x][0] = 0.10f, texels[y][x][1] = 0.13f, texels[y][x][2] = 0.20f;
    memset(&sky, 0, sizeof sky);
    sky.kind = LSAMP_LIGHT_ENVIRONMENT;
    sky.texels = &texels[0][0][0];
    sky.width = SKY_WIDTH;
    sky.height = SKY_HEIGHT;
    sky.radiance[0] = sky.radiance[1] = sky.radiance[2] = 1;
    return make_light(&sky);
}

/* ---- shading ---- */

/* Adds one light: samples from the header, visibility from rays, the sum from the header again. */
static void add_light(const lsamp_light *light, const lsamp_points *points, uint32_t seed, float *radiance)
{
    static float directions[3 * SAMPLES], distances[SAMPLES], weights[3 * SAMPLES], visible[SAMPLES];
    lsamp_samples samples = { directions, distances, NULL, weights };
    lsamp_sample_desc desc;
    int k, hit;

    memset(&desc, 0, sizeof desc);
    desc.sample_count = SAMPLES;
    desc.seed = seed;
    if (lsamp_sample(&desc, light, points, &samples, NULL) != LSAMP_OK) return;
    for (k = 0; k < SAMPLES; k++) {
        float t = trace(points->positions, directions + 3 * k, &hit);
        visible[k] = t < 0 || t > distances[k] ? 1.0f : 0.0f;
    }
    lsamp_accumulate(1, SAMPLES, weights, visible, radiance, 0);
}

int main(int count, char **values)
{
    lsamp_material materials[SPHERES + 1];
    lsamp_light *lights[2];
    FILE *file = fopen(count > 1 ? values[1] : "light.ppm", "wb");
    int x, y, c;
    uint32_t i;

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    make_materials(materials);
    lights[0] = make_lamp();
    lights[1] = make_sky();
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            float p[3], n[3], view[3], radiance[3] = { 0, 0, 0 };
            uint32_t pixel = (uint32_t)(y * WIDTH + x);
            int material;
            if (find_surface(x, y, p, n, view, &material)) {
                lsamp_points points;
                memset(&points, 0, sizeof points);
                points.count = 1;
                points.positions = p;
                points.normals = n;
                points.to_eye = view;
                points.materials = &materials[material];
                points.pixels = &pixel;
                for (i = 0; i < 2; i++) add_light(lights[i], &points, i, radiance);
            } else {
                radiance[0] = 0.10f, radiance[1] = 0.13f, radiance[2] = 0.20f;
            }
            for (c = 0; c < 3; c++)
                fputc((int)(255 * powf(radiance[c] < 1 ? radiance[c] : 1, 1 / 2.2f) + 0.5f), file);
        }
    free(lights[0]);
    free(lights[1]);
    return fclose(file) != 0;
}
