/* 01d_csm_own_views.c - coherent shadow maps of an object that is no mesh, from depth layers of your own.

   cc -O2 01d_csm_own_views.c -lm -o views && ./views pile.ppm
   ./views ball.ppm ball                           one ball, of which we know the compressed maps, so that none is drawn

   A pile of balls that run into each other has no triangles. The header names the views that it needs; this program
   answers each with two depth layers, where a ray enters the pile and where it leaves it first. A volume, a distance
   field or the depth peeling of your own renderer would do the same. The picture shows the pile's soft shadow, and
   beside it one of the maps as the header has kept it. */
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 200, BALLS = 5, SIDE = 32, MAP = 64, SAMPLES = 64 };

/* ---- the object ---- */

static float ball[BALLS][4] = {   /* centre, radius; all inside the unit sphere about the origin */
    { -0.35f, -0.25f, 0.2f, 0.42f }, { 0.4f, -0.3f, 0, 0.4f }, { 0, 0.1f, 0.1f, 0.4f }, { 0.1f, -0.3f, -0.45f, 0.38f },
    { 0.1f, 0.55f, 0.1f, 0.3f }
};
static int balls = BALLS;
static const float floor_y = -0.7f;

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Where the ray p + t d is inside of a ball; returns 0 if it misses. d has any length. */
static int cross_ball(const float *p, const float *d, const float *b, float *enter, float *leave)
{
    float v[3] = { p[0] - b[0], p[1] - b[1], p[2] - b[2] }, dd = dot(d, d), vd = dot(v, d);
    float root = vd * vd - dd * (dot(v, v) - b[3] * b[3]);
    if (root <= 0) return 0;
    root = sqrtf(root);
    *enter = (-vd - root) / dd;
    *leave = (-vd + root) / dd;
    return 1;
}

/* The first stretch of the ray, beyond t = from, that lies inside the pile: stretches that overlap are one. Returns the
   ball that it enters by, or -1. */
static int cross_pile(const float *p, const float *d, float from, float *enter, float *leave)
{
    float a, b;
    int i, first = -1, grown = 1;
    for (i = 0; i < balls; i++)
        if (cross_ball(p, d, ball[i], &a, &b) && a > from && (first < 0 || a < *enter)) {
            first = i;
            *enter = a;
            *leave = b;
        }
    while (first >= 0 && grown)
        for (grown = 0, i = 0; i < balls; i++)
            if (cross_ball(p, d, ball[i], &a, &b) && a <= *leave && b > *leave) {
                *leave = b;
                grown = 1;
            }
    return first;
}

/* ---- the maps ---- */

/* The inverse of a view's 3 x 4 matrix: pixels and depth back to the object's space. The rows of the matrix are
   orthogonal, so that each is divided by the square of its length. */
static void ray_of_pixel(const float *m, float x, float y, float *origin, float *direction)
{
    const float row[3][3] = { { m[0], m[4], m[8] }, { m[1], m[5], m[9] }, { m[2], m[6], m[10] } };
    const float at[3] = { x - m[12], y - m[13], -m[14] };
    int i, k;
    for (k = 0; k < 3; k++) {
        direction[k] = row[2][k] / dot(row[2], row[2]);
        for (origin[k] = 0, i = 0; i < 3; i++) origin[k] += at[i] * row[i][k] / dot(row[i], row[i]);
    }
}

/* Renders all views that the header asks for. */
static cohsm_maps *make_maps(void)
{
    static float z1[MAP * MAP], z2[MAP * MAP];
    cohsm_builder *builder = NULL;
    cohsm_maps *maps = NULL;
    cohsm_desc desc;
    cohsm_result result;
    uint32_t i, count;

    memset(&desc, 0, sizeof desc);
    desc.radius = 1;                                /* of the sphere about the object; its centre is 0 0 0 */
    desc.domain.side[0] = desc.domain.side[1] = SIDE;
    desc.map_side = MAP;
    result = cohsm_builder_create(&desc, &builder);
    count = cohsm_builder_view_count(builder);
    for (i = 0; i < count && result == COHSM_OK; i++) {
        cohsm_view view;
        int x, y;
        result = cohsm_builder_view(builder, i, &view);
        for (y = 0; y < MAP && result == COHSM_OK; y++)
            for (x = 0; x < MAP; x++) {
                float origin[3], direction[3], *near = &z1[y * MAP + x], *far = &z2[y * MAP + x];
                ray_of_pixel(view.matrix, (float)x + 0.5f, (float)y + 0.5f, origin, direction);
                if (cross_pile(origin, direction, 0, near, far) < 0) *near = *far = 2;      /* above 1: no hit */
            }
        if (result == COHSM_OK) result = cohsm_builder_add(builder, i, z1, z2, NULL);
    }
    if (result == COHSM_OK) result = cohsm_builder_finish(builder, &maps, NULL);
    cohsm_builder_free(builder);
    if (result == COHSM_OK) return maps;
    fprintf(stderr, "%s\n", cohsm_result_text(result));
    exit(1);
}

/* The maps of one ball about the origin, which looks the same from everywhere: one depth between its front and its
   back, that of the middle, serves a pixel in all views. So each pixel has one segment, and no view is drawn. */
static cohsm_maps *make_ball(float radius)
{
    static cohsm_segment segment[MAP * MAP];
    cohsm_builder *builder = NULL;
    cohsm_maps *maps = NULL;
    cohsm_desc desc;
    cohsm_result result;
    uint32_t i;
    for (i = 0; i < MAP * MAP; i++) {
        const float x = ((float)(i % MAP) + 0.5f) * 2 / MAP - 1, y = ((float)(i / MAP) + 0.5f) * 2 / MAP - 1;
        segment[i].pixel = i;
        /* exactly 0.5 in 16 bits; or of the grid of 8 bits the last value, infinity */
        segment[i].value = x * x + y * y < radius * radius ? 32767u | 1u << 16 : 255u | 255u << 8;
    }
    memset(&desc, 0, sizeof desc);
    desc.radius = 1;
    desc.domain.side[0] = desc.domain.side[1] = SIDE;
    desc.map_side = MAP;
    result = cohsm_builder_create(&desc, &builder);
    if (result == COHSM_OK) result = cohsm_builder_import(builder, segment, MAP * MAP);
    if (result == COHSM_OK) result = cohsm_builder_finish(builder, &maps, NULL);
    cohsm_builder_free(builder);
    if (result == COHSM_OK) return maps;
    fprintf(stderr, "%s\n", cohsm_result_text(result));
    exit(1);
}

/* ---- the picture ---- */

/* The mean over directions of a round light of visibility x cosine. */
static float shade(const cohsm_maps *maps, const float *p, const float *n)
{
    const float axis[3] = { 0.48f, 0.80f, -0.36f }, u[3] = { 0.6f, 0, 0.8f }, v[3] = { -0.64f, 0.6f, 0.48f };
    float points[3 * SAMPLES], lights[3 * SAMPLES], visible[SAMPLES], sum = 0;
    cohsm_query query;
    int i, k;
    for (i = 0; i < SAMPLES; i++) {
        float r = 0.35f * sqrtf(((float)i + 0.5f) / SAMPLES), phi = 2.39996323f * (float)i, length = sqrtf(1 + r * r);
        for (k = 0; k < 3; k++) {
            lights[3 * i + k] = (axis[k] + r * cosf(phi) * u[k] + r * sinf(phi) * v[k]) / length;
            points[3 * i + k] = p[k] + 0.01f * n[k];
        }
    }
    memset(&query, 0, sizeof query);
    query.count = SAMPLES;
    query.positions = points;
    query.lights = lights;
    if (cohsm_visible(maps, &query, visible, NULL) != COHSM_OK) return 0;
    for (i = 0; i < SAMPLES; i++) {
        float cosine = dot(n, lights + 3 * i);
        if (cosine > 0) sum += visible[i] * cosine;
    }
    return sum / SAMPLES;
}

static float pixel_value(const cohsm_maps *maps, int x, int y)
{
    static const float eye[3] = { 0, 1.1f, 3.4f };
    float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, 0.15f - ((float)y + 0.5f) / HEIGHT, -1.3f };
    float p[3], n[3], t, t2;
    int i, k;
    i = cross_pile(eye, d, 0, &t, &t2);
    if (i < 0) {
        if (d[1] >= 0) return 0.2f;
        t = (floor_y - eye[1]) / d[1];
    }
    for (k = 0; k < 3; k++) {
        p[k] = eye[k] + t * d[k];
        n[k] = i < 0 ? k == 1 : (p[k] - ball[i][k]) / ball[i][3];
    }
    return 0.05f + 0.9f * shade(maps, p, n);
}

int main(int count, char **values)
{
    static uint16_t depths[MAP * MAP];
    FILE *file = fopen(count > 1 ? values[1] : "pile.ppm", "wb");
    cohsm_maps *maps;
    int x, y, c;

    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    if (count > 2 && !strcmp(values[2], "ball")) {
        static const float one[4] = { 0, 0, 0, 0.6f };
        memcpy(ball[0], one, sizeof one);
        balls = 1;
        maps = make_ball(one[3]);
    } else {
        maps = make_maps();
    }
    if (cohsm_depths(maps, SIDE * SIDE / 3, depths) != COHSM_OK) return 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            int right = x - (WIDTH - MAP - 4), below = y - 4;       /* within the map, whose row 0 is the lowest */
            int grey = (int)(255 * powf(pixel_value(maps, x, y), 1 / 2.2f) + 0.5f);
            if (right >= 0 && right < MAP && below >= 0 && below < MAP)
                grey = depths[(MAP - 1 - below) * MAP + right] >> 8;
            for (c = 0; c < 3; c++) fputc(grey, file);
        }
    cohsm_free(maps);
    return fclose(file) != 0;
}
