/* 03b_envlights_minimal.c - a sky as directional lights, for a renderer of any kind, with envlights.h alone.

   cc -O2 03b_envlights_minimal.c -lm -o minimal && ./minimal sky.ppm lights.gltf

   A sky with a sun that wanders, as a video. The first frame becomes 64 lights, the sun one of its own; each further
   frame moves them as little as it can; the last one has twice the texels, so that its lights are built anew and take
   the places of those that they succeed. The picture shows which texels a light stands for, and the lights as dots. */
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 256, HEIGHT = 128, LIGHTS = 64, FRAMES = 12 };

static float sky[3 * WIDTH * HEIGHT];

static envlt_map make_sky(uint32_t width, uint32_t height, float time)
{
    const float sun[3] = { 0.8f * cosf(time), 0.6f, 0.8f * sinf(time) };
    envlt_map map = { ENVLT_PROJECTION_LATLONG, width, height, sky, 0 };
    for (uint32_t i = 0; i < width * height; i++) {
        float d[3], *rgb = sky + 3 * i, near_sun, glow;
        envlt_texel_direction(map.projection, width, height, 0, (float)(i % width) + 0.5f,
                              (float)(i / width) + 0.5f, d);
        near_sun = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2];
        glow = near_sun > 0.998f ? 300.0f : near_sun > 0 ? 0.6f * powf(near_sun, 16) : 0;
        rgb[0] = d[1] < 0 ? 0.10f : 0.25f + glow;
        rgb[1] = d[1] < 0 ? 0.09f : 0.35f + 0.9f * glow;
        rgb[2] = d[1] < 0 ? 0.08f : 0.60f + 0.7f * glow;
    }
    return map;
}

/* The texel that a direction falls into. */
static size_t texel_of(const float d[3])
{
    float u = 0.5f + atan2f(d[2], d[0]) / 6.2831853f, v = acosf(d[1]) / 3.1415927f;
    uint32_t x = (uint32_t)(u * WIDTH) % WIDTH, y = (uint32_t)(v * HEIGHT);
    return (y < HEIGHT ? y : HEIGHT - 1) * WIDTH + x;
}

/* Each light's texels have a colour of their own, its direction is white. */
static int write_picture(const char *path, const envlt_lights *lights)
{
    static unsigned char rgb[3 * WIDTH * HEIGHT];
    uint32_t count;
    const envlt_light *list = envlt_get_lights(lights, &count);
    const uint32_t *strata = envlt_strata(lights, NULL);
    FILE *file = fopen(path, "wb");
    if (!file) return 0;
    for (size_t t = 0; t < WIDTH * HEIGHT; t++)
        for (uint32_t c = 0; c < 3; c++)
            rgb[3 * t + c] = (unsigned char)(40 + (list[strata[t]].id + 1) * (57 + 34 * c) % 120);
    for (uint32_t i = 0; i < count; i++) memset(rgb + 3 * texel_of(list[i].direction), 255, 3);
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    fwrite(rgb, 3, WIDTH * HEIGHT, file);
    return fclose(file) == 0;
}

/* How much of the sky's detail the lights leave out: the mean of |residual| over that of the sky; 0 for a sky of as
   many even patches as there are lights. The residual itself is for reflections: each patch has the mean 0 in it. */
static int share_left_out(const envlt_lights *lights, const envlt_map *map, double *share)
{
    static float rest[3 * WIDTH * HEIGHT];
    double left = 0, all = 0;
    if (envlt_residual(lights, map, rest) != ENVLT_OK) return 0;
    for (uint32_t y = 0; y < map->height; y++) {
        double omega = envlt_texel_solid_angle(map->projection, map->width, map->height, 0, y);
        for (uint32_t x = 0; x < map->width; x++) {
            size_t t = 3 * ((size_t)y * map->width + x) + 1;
            left += omega * fabs((double)rest[t]);
            all += omega * (double)map->rgb[t];
        }
    }
    *share = left / all;
    return 1;
}

static int write_gltf(const char *path, const envlt_light *list, uint32_t count)
{
    size_t bytes = envlt_gltf_bytes(list, count);
    char *text = (char *)malloc(bytes);
    FILE *file = fopen(path, "wb");
    int written = 0;
    if (text && file && envlt_gltf_write(list, count, text, bytes) == ENVLT_OK)
        written = fwrite(text, 1, bytes - 1, file) == bytes - 1;        /* without the zero at its end */
    if (file && fclose(file) != 0) written = 0;
    free(text);
    return written;
}

int main(int count, char **values)
{
    envlt_map map = make_sky(WIDTH / 2, HEIGHT / 2, 0);
    envlt_desc desc = { 0 };
    envlt_lights *lights, *finer;
    envlt_light last[LIGHTS], now[LIGHTS];
    envlt_stats stats;
    uint32_t before, after;
    double share;

    desc.light_count = LIGHTS;
    desc.split_sun = 1;
    if (envlt_create(&desc, &map, &lights, &stats) != ENVLT_OK) return fprintf(stderr, "no lights\n"), 1;
    printf("%u lights hold %.2f W/m^2 of red light\n", (unsigned)stats.lights, stats.energy[0]);

    for (int frame = 1; frame < FRAMES; frame++) {
        map = make_sky(WIDTH / 2, HEIGHT / 2, 0.05f * (float)frame);
        if (envlt_follow(lights, &map, 0, &stats) != ENVLT_OK) return fprintf(stderr, "lost\n"), 1;
        printf("frame %2d: lights moved by %.4f radians on average, %u began anew\n", frame, (double)stats.mean_move,
               (unsigned)stats.changed);
    }
    envlt_get_lights(lights, &before);
    memcpy(last, envlt_get_lights(lights, NULL), before * sizeof *last);        /* never more than were asked for */

    /* Another size: another build, whose lights take places and ids of those nearest to them. */
    map = make_sky(WIDTH, HEIGHT, 0.05f * FRAMES);
    if (envlt_create(&desc, &map, &finer, NULL) != ENVLT_OK) return fprintf(stderr, "no lights\n"), 1;
    envlt_get_lights(finer, &after);
    memcpy(now, envlt_get_lights(finer, NULL), after * sizeof *now);
    envlt_match(last, before, now, after);
    printf("light 0 is light %u of the finer map, the sun is %s\n", (unsigned)now[0].id,
           now[0].flags & ENVLT_LIGHT_SUN ? "first" : "elsewhere");

    if (!share_left_out(finer, &map, &share)) return fprintf(stderr, "no residual\n"), 1;
    printf("as even patches the lights leave out %.0f %% of the sky's green\n", 100 * share);
    if (!write_picture(count > 1 ? values[1] : "sky.ppm", finer) ||
        !write_gltf(count > 2 ? values[2] : "lights.gltf", now, after))
        return fprintf(stderr, "cannot write the files\n"), 1;
    envlt_free(finer);
    envlt_free(lights);
    return 0;
}
