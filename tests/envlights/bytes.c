/* bytes - hashes of lights and strata: the same on every compiler and machine. Each line is
   one case. Floats are hashed by their bits, whatever the byte order. */

#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"

#include <stdio.h>

static uint32_t hash_words(uint32_t h, const void *data, size_t bytes)
{
    const char *p = (const char *)data;
    size_t i;
    for (i = 0; i + 4 <= bytes; i += 4) {
        uint32_t word;
        memcpy(&word, p + i, 4);
        h = (h ^ word) * 16777619u;
        h ^= h >> 15;
    }
    return h;
}

/* A map made of integers alone, so that it is the same everywhere. */
static void fill_map(float *rgb, size_t texels, uint32_t seed)
{
    size_t t;
    for (t = 0; t < texels; t++) {
        uint32_t h = envlt__hash_combine(seed, (uint32_t)(t / 7));
        rgb[3 * t] = (float)(h & 255u) / 64.0f;
        rgb[3 * t + 1] = (float)(h >> 8 & 255u) / 64.0f;
        rgb[3 * t + 2] = h % 37u == 0 ? 50.0f : (float)(h >> 16 & 255u) / 64.0f;
    }
}

/* 0: no more cases. */
static int bytes_case(int i, char *line, size_t size)
{
    static float rgb[3 * 40 * 20];
    int method = 1 + i % 4, cube = i / 4 % 2, variant = i / 8;
    envlt_map map;
    envlt_desc d;
    envlt_lights *l;
    const envlt_light *list;
    const uint32_t *strata;
    envlt_light moved[24];
    uint32_t count, a, b, c;
    size_t texels;
    if (i >= 16) return 0;
    memset(&map, 0, sizeof map);
    memset(&d, 0, sizeof d);
    map.projection = cube ? ENVLT_PROJECTION_CUBE : ENVLT_PROJECTION_LATLONG;
    map.width = cube ? 10 : 40;
    map.height = cube ? 10 : 20;
    map.rgb = rgb;
    d.method = (envlt_method)method;
    d.light_count = 20;
    d.hemisphere = variant;
    d.split_sun = variant;
    fill_map(rgb, cube ? 600 : 800, 1);
    if (envlt_create(&d, &map, &l, NULL) != ENVLT_OK) return 0;
    list = envlt_get_lights(l, &count);
    strata = envlt_strata(l, &texels);
    a = hash_words(hash_words(2166136261u, list, count * sizeof *list), strata, texels * 4);
    envlt_jitter(l, 3, 9, moved);
    b = hash_words(2166136261u, moved, count * sizeof *moved);
    fill_map(rgb, cube ? 600 : 800, 2);
    envlt_follow(l, &map, 24, NULL);
    list = envlt_get_lights(l, &count);
    c = hash_words(2166136261u, list, count * sizeof *list);
    envlt_free(l);
    snprintf(line, size, "method %d cube %d variant %d: lights %08x jittered %08x followed %08x\n", method, cube,
             variant, (unsigned)a, (unsigned)b, (unsigned)c);
    return 1;
}

#ifndef ENVLT_BYTES_NO_MAIN
int main(void)
{
    char line[256];
    int i;
    for (i = 0; bytes_case(i, line, sizeof line); i++) fputs(line, stdout);
    return 0;
}
#endif
