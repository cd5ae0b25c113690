/* 04b_ism_minimal.c - bounced light with shadows from imperfect shadow maps, with ism.h and nothing else.

   cc -O2 04b_ism_minimal.c -lm -o minimal && ./minimal bounce.ppm

   Sun falls through an open roof onto the red floor of a room. All that is seen is what the floor sends back, and the
   shadow that a block hanging over it throws upwards. */
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 200, RSM = 64 };

/* ---- the scene: boxes; a renderer has it anyway ---- */

typedef struct box { float lo[3], hi[3]; int inside; } box;

static const box boxes[2] = { { { -3, 0, -3 }, { 3, 3, 3 }, 1 }, { { -0.8f, 1, -1.2f }, { 0.8f, 1.3f, 0.4f }, 0 } };
static float corners[3 * 8 * 2];
static uint32_t triangles[2 * 36];

static ism_mesh make_mesh(void)
{
    static const uint32_t faces[36] = { 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                        2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5 };
    ism_mesh mesh = { corners, 16, 0, triangles, 72, NULL, NULL, NULL, NULL, NULL };
    uint32_t b, i, k;
    for (b = 0; b < 2; b++) {
        for (i = 0; i < 8; i++)
            for (k = 0; k < 3; k++) corners[3 * (8 * b + i) + k] = i >> k & 1u ? boxes[b].hi[k] : boxes[b].lo[k];
        for (i = 0; i < 36; i++) triangles[36 * b + i] = 8 * b + faces[i];
    }
    return mesh;
}

/* Nearest wall along a ray: position and normal. */
static void trace(const float *o, const float *d, float *p, float *n)
{
    float best = 1e30f;
    int b, k, side, j;
    for (b = 0; b < 2; b++)
        for (k = 0; k < 3; k++)
            for (side = 0; side < 2; side++) {
                float plane = side ? boxes[b].hi[k] : boxes[b].lo[k], t = (plane - o[k]) / d[k], q[3];
                int out = side ? 1 : -1,
                    hit = t > 1e-4f && t < best && (d[k] > 0) == (boxes[b].inside ? out > 0 : out < 0);
                for (j = 0; j < 3 && hit; j++) {
                    q[j] = j == k ? plane : o[j] + t * d[j];
                    hit = j == k || (q[j] >= boxes[b].lo[j] && q[j] <= boxes[b].hi[j]);
                }
                if (!hit) continue;
                best = t;
                for (j = 0; j < 3; j++) {
                    p[j] = q[j];
                    n[j] = j == k ? (float)(boxes[b].inside ? -out : out) : 0.0f;
                }
            }
}

int main(int count, char **values)
{
    static float at[3 * RSM * RSM], normal[3 * RSM * RSM], flux[3 * RSM * RSM], area[RSM * RSM];
    static float positions[3 * WIDTH * HEIGHT], normals[3 * WIDTH * HEIGHT], light[3 * WIDTH * HEIGHT];
    const float eye[3] = { 0, 1.6f, 2.9f }, sun[3] = { 0.1f, -1, -0.05f }, texel = 5.0f * 5.0f / (RSM * RSM);
    ism_mesh mesh = make_mesh();
    ism_source source = { ISM_SOURCE_SURFACE, RSM, RSM, 0, at, 0, normal, 0, flux, 0, area, 0, NULL, 0 };
    ism_points view = { 0 };
    ism_frame frame = { &mesh, &source, 1, &view, 0 };
    ism_shading shading = { 0 };
    ism_desc desc = { 0 };
    ism_stats stats;
    ism_maps *maps;
    ism_result result;
    FILE *file;
    int x, y, k;

    /* the reflective shadow map: what the sun sees, and how much of its light leaves there again */
    for (y = 0; y < RSM; y++)
        for (x = 0; x < RSM; x++) {
            int i = y * RSM + x;
            float from[3] = { 5 * ((float)x + 0.5f) / RSM - 2.5f, 2.99f, 5 * ((float)y + 0.5f) / RSM - 2.5f };
            trace(from, sun, at + 3 * i, normal + 3 * i);
            area[i] = texel;
            for (k = 0; k < 3; k++)         /* albedo x irradiance x area; the block is grey */
                flux[3 * i + k] =
                    (at[3 * i + 1] < 0.5f && k ? 0.2f : 0.7f) * 20 * texel * (normal[3 * i + 1] > 0.5f ? 1.0f : 0.0f);
        }
    for (y = 0; y < HEIGHT; y++)            /* the G-buffer */
        for (x = 0; x < WIDTH; x++) {
            float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, (HEIGHT / 2 - (float)y - 0.5f) / HEIGHT, -0.7f };
            trace(eye, d, positions + 3 * (y * WIDTH + x), normals + 3 * (y * WIDTH + x));
        }
    view.count = WIDTH * HEIGHT;
    view.positions = positions;
    view.normals = normals;
    view.width = WIDTH;
    desc.vpl_count = 256;
    desc.surfel_count = 4096;
    shading.interleave = 4;                    /* 16 VPLs a pixel, then a blur over 4 x 4 */
    result = ism_create(&desc, &maps);
    if (result == ISM_OK) result = ism_render(maps, &frame, &shading, light, &stats);
    if (result != ISM_OK) return fprintf(stderr, "%s\n", ism_result_text(result)), 1;
    printf("%u VPLs, %.0f points, %.1f MB\n", (unsigned)stats.vpls, (double)stats.surfels,
           (double)stats.peak_bytes * 1e-6);
    file = fopen(count > 1 ? values[1] : "bounce.ppm", "wb");
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (k = 0; k < 3 * WIDTH * HEIGHT; k++) {
        float v = powf(0.08f * light[k], 1 / 2.2f);
        fputc((int)(255 * (v < 1 ? v : 1) + 0.5f), file);
    }
    ism_free(maps);
    return fclose(file) != 0;
}
