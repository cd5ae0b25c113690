/* 03_envshadow_minimal.c - a sky's shadows on a scene that nothing is known of beforehand, with envlights.h and
   envshadow.h.

   cc -O2 03_envshadow_minimal.c -lm -o minimal && ./minimal sky.ppm

   A waving ribbon of triangles above a floor, under a sky with a sun. The sky becomes 200 directional lights; each gets
   a shadow map, rendered by the header; then all pixels ask all lights at once. */
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 200, ALONG = 120, ACROSS = 12, SKY_WIDTH = 128, SKY_HEIGHT = 64 };

/* ---- the sky: radiance by direction ---- */

static float sky[3 * SKY_WIDTH * SKY_HEIGHT];

static void make_sky(void)
{
    const float sun[3] = { 0.55f, 0.62f, 0.56f };
    for (uint32_t y = 0; y < SKY_HEIGHT; y++)
        for (uint32_t x = 0; x < SKY_WIDTH; x++) {
            float d[3], *rgb = sky + 3 * (y * SKY_WIDTH + x), glow;
            envlt_texel_direction(ENVLT_PROJECTION_LATLONG, SKY_WIDTH, SKY_HEIGHT, 0,
                                  (float)x + 0.5f, (float)y + 0.5f, d);
            glow = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2];
            glow = glow > 0.995f ? 150.0f : 0.0f;
            rgb[0] = d[1] < 0 ? 0.1f : 0.25f + glow;
            rgb[1] = d[1] < 0 ? 0.1f : 0.35f + 0.9f * glow;
            rgb[2] = d[1] < 0 ? 0.1f : 0.60f + 0.7f * glow;
        }
}

/* ---- the scene: a ribbon by its own formula, so that pixels can find it too; another `time`, another shape ---- */

static float    positions[3 * (ALONG + 1) * (ACROSS + 1)];
static uint32_t indices[6 * ALONG * ACROSS];

static float ribbon_height(float x, float z, float time) { return 1.0f + 0.35f * sinf(2.5f * x + time) + 0.2f * z; }

static envsh_mesh make_ribbon(float time)
{
    envsh_mesh mesh = { positions, (ALONG + 1) * (ACROSS + 1), 0, indices, 6 * ALONG * ACROSS, NULL, NULL, NULL };
    uint32_t i, j, n = 0;
    for (i = 0; i <= ALONG; i++)
        for (j = 0; j <= ACROSS; j++) {
            float *p = positions + 3 * (i * (ACROSS + 1) + j);
            p[0] = -2 + 4.0f * (float)i / ALONG;
            p[2] = -0.5f + (float)j / ACROSS;
            p[1] = ribbon_height(p[0], p[2], time);
        }
    for (i = 0; i < ALONG; i++)
        for (j = 0; j < ACROSS; j++) {
            uint32_t a = i * (ACROSS + 1) + j, b = a + ACROSS + 1;
            indices[n++] = a, indices[n++] = a + 1, indices[n++] = b;
            indices[n++] = b, indices[n++] = a + 1, indices[n++] = b + 1;
        }
    return mesh;
}

/* Walks along the pixel's ray to the ribbon or the floor; 0: the sky. */
static int find_surface(int x, int y, float time, float *p, float *n)
{
    float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, -0.25f - ((float)y + 0.5f) / HEIGHT, -1.2f };
    float t, last = 0, side;
    for (t = 0; t < 9; t += 0.004f, last = side) {
        p[0] = t * d[0];
        p[1] = 4.2f + t * d[1];
        p[2] = 5 + t * d[2];
        side = fabsf(p[0]) < 2 && fabsf(p[2]) < 0.5f ? p[1] - ribbon_height(p[0], p[2], time) : 0;
        if (side * last < 0) {
            float slope = 0.875f * cosf(2.5f * p[0] + time), length = sqrtf(slope * slope + 1.04f);
            float s = last > 0 ? 1.0f : -1.0f;
            n[0] = -s * slope / length;
            n[1] = s / length;
            n[2] = -s * 0.2f / length;
            return 1;
        }
        if (p[1] < 0) {
            n[0] = n[2] = 0;
            n[1] = 1;
            return 1;
        }
    }
    return 0;
}

int main(int count, char **values)
{
    static float points[3 * WIDTH * HEIGHT], normals[3 * WIDTH * HEIGHT], light[3 * WIDTH * HEIGHT];
    static int pixel[WIDTH * HEIGHT];           /* which point a pixel shows, plus 1 */
    envlt_map map = { ENVLT_PROJECTION_LATLONG, SKY_WIDTH, SKY_HEIGHT, sky, 0 };
    envsh_mesh mesh = make_ribbon(0);
    envsh_points receivers = { 0 };
    envlt_desc desc = { 0 };
    envlt_lights *lights;
    envsh_maps *maps;
    const envlt_light *list;
    envsh_lights all;
    FILE *file = fopen(count > 1 ? values[1] : "sky.ppm", "wb");

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    make_sky();
    desc.light_count = 200;
    if (envlt_create(&desc, &map, &lights, NULL) != ENVLT_OK) return fprintf(stderr, "no lights\n"), 1;
    list = envlt_get_lights(lights, &all.count);
    all.directions = list->direction;
    all.irradiances = list->irradiance;
    all.axes_u = list->axis_u;
    all.axes_v = list->axis_v;
    all.stride = sizeof *list;
    if (envsh_maps_create(NULL, all.count, &maps) != ENVSH_OK) return fprintf(stderr, "no maps\n"), 1;

    /* What follows is a frame. */
    envsh_maps_begin(maps, &all, envsh_bounds_of(&mesh, 1, NULL));
    envsh_maps_draw(maps, &mesh, NULL);
    envsh_maps_end(maps);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (find_surface(i % WIDTH, i / WIDTH, 0, points + 3 * receivers.count, normals + 3 * receivers.count))
            pixel[i] = (int)++receivers.count;
    receivers.positions = points;
    receivers.normals = normals;
    if (envsh_shade(maps, NULL, &receivers, light) != ENVSH_OK) return fprintf(stderr, "no light\n"), 1;

    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++) {           /* albedo 0.6, sRGB by its exponent */
            float L = pixel[i] ? light[3 * (pixel[i] - 1) + c] * 0.6f / 3.14159265f : 0.25f;
            fputc((int)(255 * powf(L < 1 ? L : 1, 1 / 2.2f) + 0.5f), file);
        }
    printf("%u lights, %u points\n", (unsigned)all.count, (unsigned)receivers.count);
    envsh_maps_free(maps);
    envlt_free(lights);
    return fclose(file) != 0;
}
