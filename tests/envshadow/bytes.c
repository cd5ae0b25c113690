/* bytes - hashes of lights, strata, shadow maps and shading: the same on every compiler and machine. Each line is
   one case. Floats are hashed by their bits, whatever the byte order. */

#define ENVLIGHTS_IMPLEMENTATION
#define ENVSHADOW_IMPLEMENTATION
#include "envlights.h"
#include "envshadow.h"

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
        uint32_t h = envsh__hash_combine(seed, (uint32_t)(t / 7));
        rgb[3 * t] = (float)(h & 255u) / 64.0f;
        rgb[3 * t + 1] = (float)(h >> 8 & 255u) / 64.0f;
        rgb[3 * t + 2] = h % 37u == 0 ? 50.0f : (float)(h >> 16 & 255u) / 64.0f;
    }
}

static uint32_t shade(const envlt_light *list, uint32_t count, int filter, uint32_t h)
{
    static const float p[] = { -1, 0, -1,  1, 0, -1,  0, 1.5f, 0.25f,  0.5f, 0.25f, 1,  -0.75f, 0.5f, 0.75f,  1, 1, 1 };
    static float points[3 * 100], normals[3 * 100], out[3 * 100];
    envsh_mesh mesh = { p, 6, 0, NULL, 0, NULL, NULL, NULL };
    envsh_maps_desc d;
    envsh_query q;
    envsh_points r;
    envsh_info atlas;
    envsh_lights lights;
    envsh_maps *m;
    int i;
    lights.count = count;
    lights.directions = list->direction;
    lights.irradiances = list->irradiance;
    lights.axes_u = list->axis_u;
    lights.axes_v = list->axis_v;
    lights.stride = sizeof *list;
    memset(&d, 0, sizeof d);
    memset(&q, 0, sizeof q);
    memset(&r, 0, sizeof r);
    d.map_side = 48;
    d.rgba = filter & 1;
    for (i = 0; i < 100; i++) {
        points[3 * i] = (float)(i % 10) * 0.25f - 1.0f;
        points[3 * i + 1] = 0.0f;
        points[3 * i + 2] = (float)(i / 10) * 0.25f - 1.0f;
        normals[3 * i] = normals[3 * i + 2] = 0.0f;
        normals[3 * i + 1] = 1.0f;
    }
    r.positions = points;
    r.normals = normals;
    r.count = 100;
    q.filter = (envsh_filter)(ENVSH_FILTER_PLAIN + filter);
    if (q.filter != ENVSH_FILTER_PENUMBRA) q.radius = 2.0f;
    if (envsh_maps_create(&d, count, &m) != ENVSH_OK) return 0;
    envsh_maps_begin(m, &lights, envsh_bounds_of(&mesh, 1, NULL));
    envsh_maps_draw(m, &mesh, NULL);
    envsh_maps_end(m);
    envsh_shade(m, &q, &r, out);
    envsh_get_info(m, &atlas);
    h = hash_words(h, atlas.depth, (size_t)atlas.width * atlas.height * atlas.page_count * atlas.channel_count * 4);
    envsh_maps_free(m);
    return hash_words(h, out, sizeof out);
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
    b = shade(list, count, i % 4, b);
    fill_map(rgb, cube ? 600 : 800, 2);
    envlt_follow(l, &map, 24, NULL);
    list = envlt_get_lights(l, &count);
    c = hash_words(2166136261u, list, count * sizeof *list);
    envlt_free(l);
    snprintf(line, size, "method %d cube %d variant %d: lights %08x shading %08x followed %08x\n", method, cube,
             variant, (unsigned)a, (unsigned)b, (unsigned)c);
    return 1;
}

#ifndef ENVSH_BYTES_NO_MAIN
int main(void)
{
    char line[256];
    int i;
    for (i = 0; bytes_case(i, line, sizeof line); i++) fputs(line, stdout);
    return 0;
}
#endif
