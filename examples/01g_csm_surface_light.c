/* 01g_csm_surface_light.c - soft shadows of a screen that is bent and shows four colours.

   cc -O2 01g_csm_surface_light.c -lm -o surface && ./surface screen.ppm

   The light is a surface: lightsampling.h takes it as a grid of points, and its colours as texels between which they
   are linear. Maps of what stands below look from 16 x 4 places of it, which the header gives as a table; csm.h makes
   them, and answers for each sample by the map of the place that it comes from. */
#define CSM_IMPLEMENTATION
#define LIGHTSAMPLING_IMPLEMENTATION
#include "csm.h"
#include "lightsampling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 200, SAMPLES = 64, ACROSS = 16, ALONG = 4, COLUMNS = 17, ROWS = 2, RINGS = 24,
       SIDES = 48 };

/* ---- a ball on a floor ---- */

static const float center[3] = { 0, 0.5f, 0 }, radius = 0.5f;
static float corners[3 * (RINGS + 1) * SIDES];
static uint32_t triangles[6 * RINGS * SIDES];

static void make_ball(void)
{
    uint32_t i, k, n = 0;
    for (i = 0; i < (RINGS + 1) * SIDES; i++) {
        const float theta = 3.14159265f * (float)(i / SIDES) / RINGS, phi = 6.2831853f * (float)(i % SIDES) / SIDES;
        const float unit[3] = { sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi) };
        for (k = 0; k < 3; k++) corners[3 * i + k] = center[k] + radius * unit[k];
    }
    for (i = 0; i < RINGS * SIDES; i++) {
        const uint32_t next = i - i % SIDES + (i + 1) % SIDES;
        const uint32_t two[6] = { i, next, next + SIDES, i, next + SIDES, i + SIDES };
        memcpy(triangles + n, two, sizeof two);
        n += 6;
    }
}

/* What a pixel shows: position and normal. Returns 0 for background. */
static int find_surface(int x, int y, float *p, float *n)
{
    static const float eye[3] = { 0, 1.6f, 3.6f };
    float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, 0.1f - ((float)y + 0.5f) / HEIGHT, -1.3f };
    float v[3] = { eye[0] - center[0], eye[1] - center[1], eye[2] - center[2] }, t;
    float a = 0, b = 0, c = -radius * radius;
    int k, ball;
    for (k = 0; k < 3; k++) a += d[k] * d[k], b += d[k] * v[k], c += v[k] * v[k];
    ball = b * b > a * c;
    if (!ball && d[1] >= 0) return 0;
    t = ball ? (-b - sqrtf(b * b - a * c)) / a : -eye[1] / d[1];
    for (k = 0; k < 3; k++) {
        p[k] = eye[k] + t * d[k];
        n[k] = ball ? (p[k] - center[k]) / radius : k == 1;
    }
    return 1;
}

/* ---- the light ---- */

static float grid[ROWS][COLUMNS][3];    /* an arch, whose rows run from left to right; it shines inwards */
static const float colors[4][3] = { { 5, 1, 1 }, { 1, 4, 1 }, { 1, 1, 6 }, { 4, 4, 4 } };
static lsamp_surface screen;

static void make_screen(void)
{
    int row, column;
    for (row = 0; row < ROWS; row++)
        for (column = 0; column < COLUMNS; column++) {
            const float a = 3.14159265f * (0.15f + 0.7f * (float)column / (COLUMNS - 1));
            grid[row][column][0] = -2.2f * cosf(a);
            grid[row][column][1] = 2.2f * sinf(a);
            grid[row][column][2] = -0.6f + 1.2f * (float)row;
        }
    screen.width = COLUMNS;
    screen.height = ROWS;
    screen.points = grid[0][0];
}

static lsamp_light *make_light(void)
{
    lsamp_light_desc desc;
    lsamp_light *light = NULL;
    void *memory;
    memset(&desc, 0, sizeof desc);
    desc.kind = LSAMP_LIGHT_SURFACE;
    desc.surface = &screen;
    desc.texels = colors[0];
    desc.width = 4;
    desc.height = 1;
    desc.filter = LSAMP_TEXELS_LINEAR;
    desc.radiance[0] = desc.radiance[1] = desc.radiance[2] = 1;
    memory = malloc(lsamp_light_bytes(&desc));
    return memory && lsamp_light_init(&desc, memory, lsamp_light_bytes(&desc), &light, NULL) == LSAMP_OK ? light : NULL;
}

static cohsm_maps *make_maps(void)
{
    static float locations[ACROSS * ALONG][4];
    cohsm_mesh mesh;
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    if (lsamp_surface_locations(&screen, ACROSS, ALONG, 0.01f, locations[0]) != LSAMP_OK) return NULL;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = (RINGS + 1) * SIDES;
    mesh.indices = triangles;
    mesh.index_count = 6 * RINGS * SIDES;
    memset(&desc, 0, sizeof desc);
    desc.domain.kind = COHSM_DOMAIN_TABLE;
    desc.domain.side[0] = ACROSS;
    desc.domain.side[1] = ALONG;
    desc.domain.side[2] = 1;
    desc.domain.locations = locations[0];
    desc.domain.location_count = ACROSS * ALONG;
    return cohsm_build(&desc, &mesh, &maps, NULL) == COHSM_OK ? maps : NULL;
}

/* ---- shading ---- */

static int shade(const lsamp_light *light, const cohsm_maps *maps, const float *p, const float *n, uint32_t pixel,
                 float *radiance)
{
    static float directions[3 * SAMPLES], distances[SAMPLES], coords[3 * SAMPLES], weights[3 * SAMPLES];
    static float from[3 * SAMPLES], visible[SAMPLES];
    const lsamp_samples samples = { directions, distances, coords, weights };
    lsamp_material white;
    lsamp_sample_desc desc;
    lsamp_points point;
    cohsm_query query;
    int i;
    memset(&white, 0, sizeof white);
    white.diffuse[0] = white.diffuse[1] = white.diffuse[2] = 0.7f;
    memset(&desc, 0, sizeof desc);
    desc.sample_count = SAMPLES;
    memset(&point, 0, sizeof point);
    point.count = 1;
    point.positions = p;
    point.normals = n;
    point.materials = &white;
    point.pixels = &pixel;
    if (lsamp_sample(&desc, light, &point, &samples, NULL) != LSAMP_OK) return 0;
    for (i = 0; i < 3 * SAMPLES; i++) from[i] = p[i % 3] + 0.01f * n[i % 3];
    memset(&query, 0, sizeof query);
    query.count = SAMPLES;
    query.positions = from;
    query.lights = coords;
    query.light_stride = 12;                    /* coords are three floats; a table of two sides reads two */
    query.light_kind = COHSM_LIGHT_PARAMETER;
    query.filter = COHSM_FILTER_ROULETTE;       /* between places: 64 of them alone show steps */
    query.seed = pixel;
    return cohsm_visible(maps, &query, visible, NULL) == COHSM_OK &&
           lsamp_accumulate(1, SAMPLES, weights, visible, radiance, 0) == LSAMP_OK;
}

int main(int count, char **values)
{
    FILE *file = fopen(count > 1 ? values[1] : "screen.ppm", "wb");
    lsamp_light *light;
    cohsm_maps *maps;
    int x, y, c;

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    make_ball();
    make_screen();
    light = make_light();
    maps = make_maps();
    if (!light || !maps) return fprintf(stderr, "cannot make the light or its maps\n"), 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            float p[3], n[3], radiance[3] = { 0, 0, 0 };
            if (find_surface(x, y, p, n) && !shade(light, maps, p, n, (uint32_t)(y * WIDTH + x), radiance)) return 1;
            for (c = 0; c < 3; c++)
                fputc((int)(255 * powf(radiance[c] < 1 ? radiance[c] : 1, 1 / 2.2f) + 0.5f), file);
        }
    cohsm_free(maps);
    free(light);
    return fclose(file) != 0;
}
