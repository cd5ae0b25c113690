/* 01c_lightsampling_path_tracer.c - a small path tracer whose lights and materials are those of lightsampling.h.

   cc -O2 01c_lightsampling_path_tracer.c -lm -o tracer && ./tracer bounced.ppm

   Three spheres stand on a floor under a square lamp and a pale sky, as in 01b, but light bounces between them. Where a
   path meets a surface, the header picks a point of each light and a direction of the material; a ray that meets a
   light by chance counts as well, and the balance heuristic weighs the two ways so that nothing counts twice. Frames of
   one path a pixel are averaged, first with the camera on the left, then, after a reset, from where it stays. */
#define LIGHTSAMPLING_IMPLEMENTATION
#include "lightsampling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 240, HEIGHT = 150, FRAMES = 64, BOUNCES = 5, SPHERES = 3, LIGHTS = 2 };

/* ---- what a renderer has anyway: surfaces, rays, random numbers ---- */

static const float center[SPHERES][3] = { { -1.3f, 0.6f, 0 }, { 0, 0.6f, 0.4f }, { 1.3f, 0.6f, 0 } }, radius = 0.6f;

typedef struct surface {
    float position[3], normal[3];
    int   material;
} surface;

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Returns the distance along a ray with unit direction d to the nearest sphere or the floor, and writes what it meets;
   -1: nothing. */
static float trace(const float *p, const float *d, surface *out)
{
    float best = p[1] > 1e-3f && d[1] < 0 ? -p[1] / d[1] : -1;
    int which = SPHERES, i, k;
    for (i = 0; i < SPHERES; i++) {
        float v[3] = { p[0] - center[i][0], p[1] - center[i][1], p[2] - center[i][2] }, b = dot(v, d), t;
        float root = b * b - (dot(v, v) - radius * radius);
        if (root < 0) continue;
        t = -b - sqrtf(root);
        if (t > 1e-3f && (best < 0 || t < best)) {
            best = t;
            which = i;
        }
    }
    for (k = 0; k < 3 && best >= 0; k++) {
        out->position[k] = p[k] + best * d[k];
        out->normal[k] = which == SPHERES ? k == 1 : (out->position[k] - center[which][k]) / radius;
    }
    out->material = which;
    return best;
}

/* A number in [0, 1); the next call returns another one. */
static float random_number(uint32_t *state)
{
    uint32_t h = *state = *state * 747796405u + 2891336453u;
    h = (h >> (h >> 28 & 15) ^ h) * 277803737u;
    return (float)((h ^ h >> 22) >> 8) / 16777216.0f;
}

/* ---- paths ---- */

typedef struct scene {
    lsamp_light   *lights[LIGHTS];
    lsamp_material materials[SPHERES + 1];
    float         *patterns;        /* where the first light samples of a pixel lie, frame by frame */
} scene;

/* What a ray sees of the lights before distance t (-1: nothing is in its way). pdf: with which a material picked its
   direction; 0: the camera did, so that no other way leads here. */
static void add_seen(const scene *s, const float *p, const float *d, float t, float pdf, const float *throughput,
                     float *radiance)
{
    int i, c;
    for (i = 0; i < LIGHTS; i++) {
        lsamp_emission e;
        float share = 1;
        if (!lsamp_light_hit(s->lights[i], p, d, &e) || (t >= 0 && t < e.distance)) continue;
        if (pdf > 0) share = pdf / (pdf + e.pdf);
        for (c = 0; c < 3; c++) radiance[c] += throughput[c] * e.radiance[c] * share;
    }
}

/* A point of each light, picked by the light, and what comes from there. u: random numbers for the first light. */
static void add_picked(const scene *s, const surface *at, const float *to_eye, const float *u, uint32_t *random,
                       const float *throughput, float *radiance)
{
    int i, c;
    for (i = 0; i < LIGHTS; i++) {
        float numbers[3] = { u[0], u[1], 0 }, f[3], pdf, cosine;
        lsamp_emission e;
        surface blocked;
        if (i > 0) numbers[0] = random_number(random), numbers[1] = random_number(random);
        if (!lsamp_light_sample(s->lights[i], at->position, numbers, &e)) continue;
        cosine = dot(at->normal, e.direction);
        if (cosine <= 0) continue;
        if (lsamp_brdf_eval(&s->materials[at->material], at->normal, NULL, to_eye, e.direction, f, &pdf) != LSAMP_OK)
            continue;
        cosine /= e.pdf + pdf;                      /* cos / pdf times the balance heuristic's share of the light */
        if (trace(at->position, e.direction, &blocked) >= 0) {
            float v[3];
            for (c = 0; c < 3; c++) v[c] = blocked.position[c] - at->position[c];
            if (dot(v, v) < e.distance * e.distance) continue;
        }
        for (c = 0; c < 3; c++) radiance[c] += throughput[c] * f[c] * e.radiance[c] * cosine;
    }
}

/* Follows one path from the eye along d and adds the light that comes back along it. first: random numbers for a light
   sample of its first surface. */
static void follow(const scene *s, const float *eye, const float *direction, const float *first, uint32_t *random,
                   float *radiance)
{
    float p[3], d[3], u[2];
    float throughput[3] = { 1, 1, 1 }, pdf = 0;
    int bounce, c;
    memcpy(p, eye, sizeof p);
    memcpy(d, direction, sizeof d);
    memcpy(u, first, sizeof u);
    for (bounce = 0; bounce < BOUNCES; bounce++) {
        surface at;
        float t = trace(p, d, &at), to_eye[3] = { -d[0], -d[1], -d[2] }, f[3], cosine;
        add_seen(s, p, d, t, pdf, throughput, radiance);
        if (t < 0) return;
        add_picked(s, &at, to_eye, u, random, throughput, radiance);
        u[0] = random_number(random);
        u[1] = random_number(random);
        if (lsamp_brdf_sample(&s->materials[at.material], at.normal, NULL, to_eye, u, d, f, &pdf) != LSAMP_OK) return;
        if (pdf <= 0) return;
        cosine = dot(at.normal, d);
        for (c = 0; c < 3; c++) throughput[c] *= f[c] * cosine / pdf;
        memcpy(p, at.position, sizeof p);
        u[0] = random_number(random);
        u[1] = random_number(random);
    }
}

/* One path for each pixel. Pixels that lie near each other take other patterns, and each frame the pattern's next
   point. */
static void draw_frame(const scene *s, float camera_x, uint32_t frame, float *picture)
{
    uint32_t random = frame * 7919u + 1;
    int x, y, k;
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            const uint32_t pattern = ((uint32_t)x * 61u + (uint32_t)y * 151u) % LSAMP_PATTERN_COUNT;
            const float *u = s->patterns + 2 * ((size_t)pattern * FRAMES + frame % FRAMES);
            float *radiance = picture + 3 * ((size_t)y * WIDTH + (size_t)x), eye[3] = { 0, 2.2f, 5.2f }, d[3], length;
            eye[0] = camera_x;
            d[0] = ((float)x + random_number(&random) - WIDTH / 2) / HEIGHT - 0.2f * camera_x;
            d[1] = 0.15f - ((float)y + random_number(&random)) / HEIGHT;
            d[2] = -1.2f;
            length = sqrtf(dot(d, d));
            for (k = 0; k < 3; k++) {
                d[k] /= length;
                radiance[k] = 0;
            }
            follow(s, eye, d, u, &random, radiance);
        }
}

/* ---- lights and materials ---- */

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

static void make_scene(scene *s)
{
    static const float colors[SPHERES + 1][3] = { { 0.8f, 0.4f, 0.3f }, { 0.1f, 0.3f, 0.6f }, { 0.9f, 0.7f, 0.3f },
                                                  { 0.5f, 0.5f, 0.5f } };
    const size_t bytes = lsamp_patterns_bytes(FRAMES);
    lsamp_light_desc lamp, sky;
    int i;

    memset(s, 0, sizeof *s);
    for (i = 0; i <= SPHERES; i++) memcpy(s->materials[i].diffuse, colors[i], sizeof colors[i]);
    s->materials[1].kind = LSAMP_MATERIAL_PHONG;
    s->materials[1].specular[0] = s->materials[1].specular[1] = s->materials[1].specular[2] = 0.3f;
    s->materials[1].exponent = 60;
    s->materials[2].kind = LSAMP_MATERIAL_METAL_ROUGH;
    s->materials[2].metallic = 1;
    s->materials[2].roughness = 0.3f;

    memset(&lamp, 0, sizeof lamp);
    lamp.kind = LSAMP_LIGHT_RECTANGLE;              /* a corner and two edges; it shines along u x v: down */
    lamp.position[0] = -2.3f, lamp.position[1] = 2.6f, lamp.position[2] = -0.8f;
    lamp.u[0] = 1.5f;
    lamp.v[2] = 1.5f;
    lamp.radiance[0] = 7, lamp.radiance[1] = 6, lamp.radiance[2] = 4;
    s->lights[0] = make_light(&lamp);
    memset(&sky, 0, sizeof sky);
    sky.kind = LSAMP_LIGHT_ENVIRONMENT;             /* without texels it is the same everywhere */
    sky.radiance[0] = 0.10f, sky.radiance[1] = 0.13f, sky.radiance[2] = 0.20f;
    s->lights[1] = make_light(&sky);

    s->patterns = (float *)malloc(bytes);
    if (!s->patterns || lsamp_patterns_build(FRAMES, 1, s->patterns, bytes) != LSAMP_OK) exit(1);
}

int main(int count, char **values)
{
    static float frame[3 * WIDTH * HEIGHT], mean[3 * WIDTH * HEIGHT];
    static double sums[3 * WIDTH * HEIGHT];
    lsamp_progressive average = { sums, 3 * WIDTH * HEIGHT, 0 };
    FILE *file = fopen(count > 1 ? values[1] : "bounced.ppm", "wb");
    scene s;
    uint32_t i;
    size_t k;

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    make_scene(&s);
    lsamp_progressive_reset(&average);
    for (i = 0; i < FRAMES + 4; i++) {
        if (i == 4) lsamp_progressive_reset(&average);      /* the camera moved: what was added is of another place */
        draw_frame(&s, i < 4 ? -1.0f : 0.0f, i, frame);
        lsamp_progressive_add(&average, frame);
    }
    lsamp_progressive_mean(&average, mean);
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (k = 0; k < 3 * WIDTH * HEIGHT; k++)
        fputc((int)(255 * powf(mean[k] < 1 ? mean[k] : 1, 1 / 2.2f) + 0.5f), file);
    free(s.lights[0]);
    free(s.lights[1]);
    free(s.patterns);
    return fclose(file) != 0;
}
