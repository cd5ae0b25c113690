/* 04a_rsm_minimal.c - one bounce of light from a reflective shadow map, with rsm.h and nothing else.

   cc -O2 04a_rsm_minimal.c -lm -o minimal && ./minimal bounce.ppm

   A sun shines through the open side of a room onto its floor and red wall; what comes back lights the rest. Each
   pixel's direct light comes from the map's depth, its bounced light from 256 of the map's texels, chosen by their
   flux. */
#define RSM_IMPLEMENTATION
#include "rsm.h"

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 200, PIXELS = WIDTH * HEIGHT };

/* Floor, back, left, right and a block in the room: parallelograms by corner, edge, edge. */
enum { QUADS = 9 };
static const float quads[QUADS][9] = { { -2, 0, -2, 4, 0, 0, 0, 0, 4 },
                                       { -2, 0, -2, 4, 0, 0, 0, 3, 0 },
                                       { -2, 0, -2, 0, 0, 4, 0, 3, 0 },
                                       { 2, 0, -2, 0, 0, 4, 0, 3, 0 },
                                       { 0.3f, 0, -1, 0.9f, 0, 0.4f, 0, 1.3f, 0 },
                                       { 0.3f, 0, -1, -0.4f, 0, 0.9f, 0, 1.3f, 0 },
                                       { 0.3f, 1.3f, -1, 0.9f, 0, 0.4f, -0.4f, 0, 0.9f },
                                       { 1.2f, 0, -0.6f, -0.4f, 0, 0.9f, 0, 1.3f, 0 },
                                       { -0.1f, 0, -0.1f, 0.9f, 0, 0.4f, 0, 1.3f, 0 } };
static const float colors[QUADS][3] = {
    { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.1f, 0.1f }, { 0.15f, 0.6f, 0.2f }, { 0.7f, 0.7f, 0.7f },
    { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.7f, 0.7f }
};

static float positions[3 * PIXELS], normals[3 * PIXELS], albedo[3 * PIXELS], light[3 * PIXELS], bounce[3 * PIXELS];

/* ---- what a renderer has anyway: the surface that a pixel shows, here by a ray against each parallelogram ---- */

static void cross(const float *a, const float *b, float *out)
{
    int k;
    for (k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void find_surface(int pixel)
{
    const float eye[3] = { 0, 1.6f, 6.5f };
    float ray[3], nearest = 1e9f;
    int q, k;
    ray[0] = ((float)(pixel % WIDTH) + 0.5f - WIDTH / 2) / HEIGHT;
    ray[1] = (HEIGHT / 2 - (float)(pixel / WIDTH) - 0.5f) / HEIGHT - 0.02f;
    ray[2] = -1.35f;
    for (q = 0; q < QUADS; q++) {
        float n[3], to[3], m[3];
        float t, u, v, length;
        cross(quads[q] + 3, quads[q] + 6, n);
        for (k = 0; k < 3; k++) to[k] = quads[q][k] - eye[k];
        t = dot(to, n) / dot(ray, n);
        if (!(t > 0 && t < nearest)) continue;
        for (k = 0; k < 3; k++) to[k] = eye[k] + t * ray[k] - quads[q][k];
        cross(to, quads[q] + 6, m);
        u = dot(m, n) / dot(n, n);
        cross(quads[q] + 3, to, m);
        v = dot(m, n) / dot(n, n);
        if (u < 0 || u > 1 || v < 0 || v > 1) continue;
        nearest = t;
        length = sqrtf(dot(n, n)) * (dot(n, ray) > 0 ? -1.0f : 1.0f);
        for (k = 0; k < 3; k++) {
            positions[3 * pixel + k] = eye[k] + t * ray[k];
            normals[3 * pixel + k] = n[k] / length;
            albedo[3 * pixel + k] = colors[q][k];
        }
    }
}

/* ---- the map: one small mesh for each colour ---- */

static rsm_map *make_map(void)
{
    static const uint32_t indices[6] = { 0, 1, 2, 0, 2, 3 };
    static float corners[QUADS][12];
    rsm_mesh meshes[QUADS];
    rsm_desc desc = { 0 };
    rsm_map *map;
    int q, k;
    for (q = 0; q < QUADS; q++) {
        rsm_mesh mesh = { 0 };
        for (k = 0; k < 3; k++) {
            corners[q][k] = quads[q][k];
            corners[q][3 + k] = quads[q][k] + quads[q][3 + k];
            corners[q][6 + k] = quads[q][k] + quads[q][3 + k] + quads[q][6 + k];
            corners[q][9 + k] = quads[q][k] + quads[q][6 + k];
            mesh.albedo[k] = colors[q][k];
        }
        mesh.positions = corners[q];
        mesh.vertex_count = 4;
        mesh.indices = indices;
        mesh.index_count = 6;
        meshes[q] = mesh;
    }
    desc.light.direction[0] = 0.48f, desc.light.direction[1] = 0.64f, desc.light.direction[2] = 0.6f; /* to the sun */
    desc.light.value[0] = 6, desc.light.value[1] = 5.6f, desc.light.value[2] = 5;                         /* W/m^2 */
    desc.light.position[1] = 1.2f;
    desc.light.radius = 3.5f;
    if (rsm_map_create(&desc, &map) != RSM_OK) return NULL;
    if (rsm_rasterize(map, meshes, QUADS) == RSM_OK && rsm_finish(map, NULL) == RSM_OK) return map;
    rsm_map_free(map);
    return NULL;
}

int main(int count, char **values)
{
    rsm_gather_desc gather = { 0 };
    rsm_points points = { 0 };
    rsm_map *map = make_map();
    FILE *file = fopen(count > 1 ? values[1] : "bounce.ppm", "wb");
    int i;

    if (!file || !map) return fprintf(stderr, "cannot write the picture, or out of memory\n"), 1;
    for (i = 0; i < PIXELS; i++) find_surface(i);
    points.count = PIXELS;
    points.positions = positions;
    points.normals = normals;
    gather.sample_count = 256;
    gather.near_limit = 0.3f;                                /* no bright spots in corners */
    if (rsm_direct(map, NULL, &points, light) != RSM_OK) return 1;
    if (rsm_gather((const rsm_map *const *)&map, 1, &gather, &points, bounce, NULL) != RSM_OK) return 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (i = 0; i < 3 * PIXELS; i++) {
        float radiance = albedo[i] * (light[i] + bounce[i]) / 3.14159265f;
        fputc((int)(255 * powf(radiance < 1 ? radiance : 1, 1 / 2.2f) + 0.5f), file);
    }
    rsm_map_free(map);
    return fclose(file) != 0;
}
