/* 03c_envshadow_own_maps.c - lights, shadow maps and shading of your own around envshadow.h, which needs no other
   header.

   cc -O2 03c_envshadow_own_maps.c -lm -o own_maps && ./own_maps balls.ppm

   Three lamps far away, given as plain arrays; balls that are no meshes, whose depth this program finds by itself for
   each map, as a renderer on another API would; and shiny surfaces, for which the header says light by light how much
   of it arrives. For one point in the penumbra of each light it asks the depths in this program's memory too: in this
   way you can check the answers of a shader that you wrote for another API. */
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 200, LIGHTS = 3, BALLS = 4, SIDE = 512 };

/* Unit directions, irradiance, and discs of 3 to 6 degrees' radius: their two half axes. */
static const float directions[LIGHTS][3] = { { 0.6f, 0.8f, 0 }, { -0.48f, 0.6f, 0.64f }, { 0, 0.8f, -0.6f } };
static const float irradiances[LIGHTS][3] = { { 2.4f, 2.2f, 1.8f }, { 0.3f, 0.5f, 1.0f }, { 0.8f, 0.3f, 0.2f } };
static const float axes_u[LIGHTS][3] = { { 0, 0, 0.05f }, { 0.08f, 0, 0.06f }, { 0.1f, 0, 0 } };
static const float axes_v[LIGHTS][3] = { { 0.04f, -0.03f, 0 }, { 0.036f, 0.08f, -0.048f }, { 0, 0.06f, 0.08f } };

static const float balls[BALLS][4] = {      /* centre, radius */
    { 0, 0.6f, 0, 0.6f }, { 1.3f, 0.35f, 0.3f, 0.35f }, { -1.2f, 1.1f, -0.2f, 0.4f }, { 0.5f, 1.5f, -0.5f, 0.25f }
};

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* ---- depth: the front of each ball in the tile of a light ---- */

static void draw_balls(const envsh_view *v, float *depth)
{
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = 1;             /* nothing there */
    for (int b = 0; b < BALLS; b++) {
        float at[3];                                                /* the centre: texels, texels, depth */
        for (int k = 0; k < 3; k++) at[k] = dot(v->lookup + 4 * k, balls[b]) + v->lookup[4 * k + 3];
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                float dx = ((float)x + 0.5f - at[0]) * v->texel[0], dy = ((float)y + 0.5f - at[1]) * v->texel[1];
                float rest = balls[b][3] * balls[b][3] - dx * dx - dy * dy, z;
                if (rest < 0) continue;
                z = at[2] - sqrtf(rest) / v->depth_range;
                if (z < depth[y * SIDE + x]) depth[y * SIDE + x] = z;
            }
    }
}

/* ---- the picture: a ray for each pixel ---- */

static const float eye[3] = { 0, 2.2f, 5 };

/* Point and normal of what the ray sees first; 0: nothing. */
static int find_surface(const float *d, float *p, float *n)
{
    float nearest = d[1] < 0 ? -eye[1] / d[1] : 1e9f, length = sqrtf(dot(d, d));
    int hit = -1;
    for (int b = 0; b < BALLS; b++) {
        float o[3];
        float q, c, root, t;
        for (int k = 0; k < 3; k++) o[k] = eye[k] - balls[b][k];
        q = dot(o, d) / length;
        c = q * q - dot(o, o) + balls[b][3] * balls[b][3];
        if (c < 0) continue;
        root = sqrtf(c);
        t = (-q - root) / length;
        if (t > 0 && t < nearest) nearest = t, hit = b;
    }
    if (nearest > 30) return 0;
    for (int k = 0; k < 3; k++) p[k] = eye[k] + nearest * d[k];
    for (int k = 0; k < 3; k++) n[k] = hit < 0 ? (float)(k == 1) : (p[k] - balls[hit][k]) / balls[hit][3];
    return 1;
}

/* Lambert, and Blinn's highlight: what is reflected to the eye where a plane that faces the light gets 1 W/m^2. */
static float reflect(const float *p, const float *n, const float *l)
{
    float h[3], view[3];
    float length = 0, cosine = dot(n, l), far_off;
    if (cosine <= 0) return 0;
    for (int k = 0; k < 3; k++) view[k] = eye[k] - p[k];
    far_off = sqrtf(dot(view, view));
    for (int k = 0; k < 3; k++) h[k] = l[k] + view[k] / far_off;
    length = sqrtf(dot(h, h));
    return cosine * (0.5f / 3.14159265f + 0.6f * powf(fmaxf(dot(n, h) / length, 0), 80));
}

int main(int count, char **values)
{
    static float points[3 * WIDTH * HEIGHT], normals[3 * WIDTH * HEIGHT], visible[WIDTH * HEIGHT];
    static float picture[3 * WIDTH * HEIGHT], depth[LIGHTS][SIDE * SIDE];
    static int place[WIDTH * HEIGHT];               /* the pixel that a point is seen in */
    envsh_lights lights = { LIGHTS, directions[0], irradiances[0], axes_u[0], axes_v[0], 0 };
    envsh_bounds bounds = { { -1.6f, 0, -0.75f }, { 1.65f, 1.75f, 0.65f } };
    envsh_points receivers = { 0 };
    envsh_maps_desc desc = { 0 };
    envsh_maps *maps;
    const envsh_view *views;
    FILE *file = fopen(count > 1 ? values[1] : "balls.ppm", "wb");

    desc.map_side = SIDE;
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    if (envsh_maps_create(&desc, LIGHTS, &maps) != ENVSH_OK) return fprintf(stderr, "no maps\n"), 1;
    if (envsh_maps_begin(maps, &lights, bounds) != ENVSH_OK) return fprintf(stderr, "no lights\n"), 1;
    views = envsh_views(maps, NULL);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        draw_balls(&views[i], depth[i]);
        envsh_maps_set(maps, i, depth[i], 0);
    }
    envsh_maps_end(maps);

    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float x = ((float)(i % WIDTH) + 0.5f) / HEIGHT, y = ((float)(i / WIDTH) + 0.5f) / HEIGHT;
        float d[3] = { x - 0.8f, 0.18f - y, -1.1f };
        size_t at = 3 * receivers.count;
        if (find_surface(d, points + at, normals + at)) place[receivers.count++] = i;
    }
    receivers.positions = points;
    receivers.normals = normals;
    for (uint32_t i = 0; i < LIGHTS; i++) {
        envsh_tile tile = { &views[i], depth[i], SIDE * sizeof(float), sizeof(float), SIDE };
        size_t at = 0;
        if (envsh_visible(maps, i, NULL, &receivers, visible) != ENVSH_OK) return fprintf(stderr, "no light\n"), 1;
        while (at + 1 < receivers.count && (visible[at] <= 0 || visible[at] >= 1)) at++;
        printf("point %u sees %.3f of light %u, by the tile alone %.3f\n", (unsigned)at, (double)visible[at],
               (unsigned)i,
               (double)envsh_visibility_twin(&tile, NULL, points + 3 * at, normals + 3 * at, (uint32_t)at));
        for (size_t k = 0; k < receivers.count; k++)
            for (int c = 0; c < 3; c++)
                picture[3 * place[k] + c] += visible[k] * irradiances[i][c] *
                                             reflect(points + 3 * k, normals + 3 * k, directions[i]);
    }
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)        /* sRGB by its exponent */
        fputc((int)(255 * powf(fminf(picture[i], 1), 1 / 2.2f) + 0.5f), file);
    envsh_maps_free(maps);
    return fclose(file) != 0;
}
