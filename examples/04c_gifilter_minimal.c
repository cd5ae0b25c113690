/* 04c_gifilter_minimal.c - noisy light made smooth over frames and neighbours, with gifilter.h and nothing else.

   cc -O2 04c_gifilter_minimal.c -lm -o minimal && ./minimal filtered.ppm

   A sphere on a floor under an even sky. Each pixel of each frame asks one ray whether it sees the sky: yes or no,
   black or white. The camera goes round the sphere; the picture shows the last frame's rays on the left and what the
   filter made of all frames on the right. After four frames the scene is another one, with a smaller sphere. */
#define GIFILTER_IMPLEMENTATION
#include "gifilter.h"

#include <stdio.h>

enum { WIDTH = 320, HEIGHT = 200, PIXELS = WIDTH * HEIGHT, CUT = 4, FRAMES = 20 };

static float radius = 1.4f;             /* of the sphere, which lies on the floor */
static float positions[3 * PIXELS], normals[3 * PIXELS], rays[3 * PIXELS], light[3 * PIXELS];

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static float random_unit(void)
{
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / 16777216.0f;
}

/* ---- what a renderer has anyway: the surface that a ray meets, here a sphere or the floor y = 0 ---- */

static int trace(const float *from, const float *ray, float *position, float *normal)
{
    const float to[3] = { from[0], from[1] - radius, from[2] };
    float b = dot(to, ray), c = dot(to, to) - radius * radius, root = b * b - c, t;
    int k;
    if (root > 0 && -b - sqrtf(root) > 1e-3f) {
        t = -b - sqrtf(root);
        for (k = 0; k < 3; k++) position[k] = from[k] + t * ray[k];
        for (k = 0; k < 3; k++) normal[k] = (position[k] - (k == 1 ? radius : 0.0f)) / radius;
        return 1;
    }
    t = -from[1] / ray[1];
    if (!(ray[1] < 0 && t > 1e-3f && t < 40)) return 0;
    for (k = 0; k < 3; k++) position[k] = from[k] + t * ray[k];
    normal[0] = normal[2] = 0;
    normal[1] = 1;
    return 1;
}

/* ---- the camera: on a circle about the sphere, looking at it ---- */

typedef struct camera { float eye[3], right[3], up[3], back[3]; } camera;

static camera camera_at(float angle)
{
    const float s = sinf(angle), c = cosf(angle), down = 0.28f, length = sqrtf(1 + down * down);
    camera m = { { 0 }, { 0 }, { 0 }, { 0 } };
    m.back[0] = s / length, m.back[1] = down / length, m.back[2] = c / length;
    m.right[0] = c, m.right[2] = -s;
    m.up[0] = -down * s / length, m.up[1] = 1 / length, m.up[2] = -down * c / length;
    m.eye[0] = 5 * m.back[0], m.eye[1] = 0.8f + 5 * m.back[1], m.eye[2] = 5 * m.back[2];
    return m;
}

/* World to clip, the picture 0.4 high at distance 1 on either side. Depth plays no part: clip z is w. */
static void world_to_clip(const camera *m, float clip[16])
{
    int k;
    for (k = 0; k < 3; k++) {
        clip[4 * k] = m->right[k] / (0.4f * WIDTH / HEIGHT);
        clip[4 * k + 1] = m->up[k] / 0.4f;
        clip[4 * k + 2] = clip[4 * k + 3] = -m->back[k];
    }
    clip[12] = -dot(m->right, m->eye) / (0.4f * WIDTH / HEIGHT);
    clip[13] = -dot(m->up, m->eye) / 0.4f;
    clip[14] = clip[15] = dot(m->back, m->eye);
}

/* Place and normal of what a pixel shows, and its one ray's answer. */
static void draw(const camera *m, int pixel)
{
    const float x = (((float)(pixel % WIDTH) + 0.5f) / WIDTH * 2 - 1) * 0.4f * WIDTH / HEIGHT;
    const float y = (1 - ((float)(pixel / WIDTH) + 0.5f) / HEIGHT * 2) * 0.4f;
    float ray[3], length = sqrtf(x * x + y * y + 1), any[3], out[3];
    float *p = positions + 3 * pixel, *n = normals + 3 * pixel;
    int k;
    for (k = 0; k < 3; k++) ray[k] = (m->right[k] * x + m->up[k] * y - m->back[k]) / length;
    if (!trace(m->eye, ray, p, n)) {
        for (k = 0; k < 3; k++) n[k] = 0, rays[3 * pixel + k] = 0;      /* no surface: no receiver */
        return;
    }
    /* A point of the unit sphere about the normal's tip: directions by the cosine. */
    any[1] = 2 * random_unit() - 1;
    any[0] = sqrtf(1 - any[1] * any[1]), any[2] = random_unit() * 6.2831853f;
    out[0] = n[0] + any[0] * cosf(any[2]), out[1] = n[1] + any[1], out[2] = n[2] + any[0] * sinf(any[2]);
    length = sqrtf(dot(out, out)) + 1e-6f;
    for (k = 0; k < 3; k++) out[k] /= length;
    length = trace(p, out, any, ray) || out[1] <= 0 ? 0.0f : 1.0f;
    for (k = 0; k < 3; k++) rays[3 * pixel + k] = length;
}

int main(int count, char **values)
{
    FILE *file = fopen(count > 1 ? values[1] : "filtered.ppm", "wb");
    gifilt_filter *filter;
    gifilt_points points = { 0 };
    gifilt_desc size = { 0 };
    gifilt_frame settings = { 0 };
    gifilt_result result;
    float clip[16];
    int frame, i, k;

    size.width = WIDTH;
    size.height = HEIGHT;
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    result = gifilt_create(&size, &filter);
    if (result != GIFILT_OK) return fprintf(stderr, "gifilt_create: %s\n", gifilt_result_text(result)), 1;
    points.count = PIXELS;
    points.positions = positions;
    points.normals = normals;
    settings.rows = GIFILT_ROWS_TOP_FIRST;
    settings.world_to_clip = clip;
    settings.history = 16;
    settings.passes = 3;
    for (frame = 0; frame < FRAMES; frame++) {
        camera m = camera_at(0.02f * (float)frame);
        if (frame == CUT) {
            radius = 1;
            gifilt_reset(filter);                       /* what it knew is not of this scene */
        }
        for (i = 0; i < PIXELS; i++) draw(&m, i);
        world_to_clip(&m, clip);
        result = gifilt_apply(filter, &settings, &points, rays, light);
        if (result != GIFILT_OK) return fprintf(stderr, "gifilt_apply: %s\n", gifilt_result_text(result)), 1;
    }
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (i = 0; i < PIXELS; i++)
        for (k = 0; k < 3; k++) {
            float e = i % WIDTH < WIDTH / 2 ? rays[3 * i + k] : light[3 * i + k];
            fputc((int)(255 * powf(e < 1 ? e : 1, 1 / 2.2f) + 0.5f), file);
        }
    gifilt_free(filter);
    return fclose(file) != 0;
}
