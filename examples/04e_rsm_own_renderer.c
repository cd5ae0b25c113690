/* 04e_rsm_own_renderer.c - a lamp's reflective shadow map drawn by a renderer of your own, anew each frame, with
   rsm.h and nothing else.

   cc -O2 04e_rsm_own_renderer.c -lm -o own && ./own swing.ppm

   A lamp swings through a room. In each frame its map is emptied, drawn face by face with the matrices of the map,
   and made a list of 256 pixel lights, which become 24 area lights; these light the picture. The four pictures stand
   side by side. A line for each says what is in the map, and whether the lamp sees the floor right of the block. */
#define RSM_IMPLEMENTATION
#include "rsm.h"

#include <stdio.h>

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT, FRAMES = 4, SIDE = 96, LIGHTS = 256, CLUSTERS = 24 };

/* Floor, back, left, right, ceiling and a block: parallelograms by corner, edge, edge. */
enum { QUADS = 9 };
static const float quads[QUADS][9] = { { -2, 0, -2, 4, 0, 0, 0, 0, 6 },
                                       { -2, 0, -2, 4, 0, 0, 0, 3, 0 },
                                       { -2, 0, -2, 0, 0, 6, 0, 3, 0 },
                                       { 2, 0, -2, 0, 0, 6, 0, 3, 0 },
                                       { -2, 3, -2, 4, 0, 0, 0, 0, 6 },
                                       { -0.4f, 0, -0.4f, 0.8f, 0, 0, 0, 1.2f, 0 },
                                       { -0.4f, 0, 0.4f, 0.8f, 0, 0, 0, 1.2f, 0 },
                                       { -0.4f, 0, -0.4f, 0, 0, 0.8f, 0, 1.2f, 0 },
                                       { 0.4f, 0, -0.4f, 0, 0, 0.8f, 0, 1.2f, 0 } };
static const float colors[QUADS][3] = {
    { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.7f, 0.7f }, { 0.7f, 0.1f, 0.1f },  { 0.15f, 0.6f, 0.2f }, { 0.7f, 0.7f, 0.7f },
    { 0.6f, 0.6f, 0.7f }, { 0.6f, 0.6f, 0.7f }, { 0.6f, 0.6f, 0.7f }, { 0.6f, 0.6f, 0.7f }
};

/* What a renderer draws: for each pixel the place, the normal and the colour of what it shows. */
typedef struct buffers { float positions[3 * PIXELS], normals[3 * PIXELS], albedo[3 * PIXELS]; } buffers;

static buffers seen, drawn;              /* by the camera; by the lamp, of whose pixels SIDE * SIDE are used */
static float light[3 * PIXELS], bounce[3 * PIXELS];
static unsigned char picture[FRAMES][3 * PIXELS];

/* ---- the renderer: a ray against each parallelogram ---- */

static void cross(const float *a, const float *b, float *out)
{
    int k;
    for (k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void draw_pixel(buffers *to, int pixel, const float *eye, const float *ray)
{
    float nearest = 1e9f;
    int q, k;
    for (k = 0; k < 3; k++) to->normals[3 * pixel + k] = 0;     /* 0 0 0: nothing there */
    for (q = 0; q < QUADS; q++) {
        float n[3], from[3], m[3];
        float t, u, v;
        cross(quads[q] + 3, quads[q] + 6, n);
        for (k = 0; k < 3; k++) from[k] = quads[q][k] - eye[k];
        t = dot(from, n) / dot(ray, n);
        if (!(t > 1e-4f && t < nearest)) continue;
        for (k = 0; k < 3; k++) from[k] = eye[k] + t * ray[k] - quads[q][k];
        cross(from, quads[q] + 6, m);
        u = dot(m, n) / dot(n, n);
        cross(quads[q] + 3, from, m);
        v = dot(m, n) / dot(n, n);
        if (u < 0 || u > 1 || v < 0 || v > 1) continue;
        nearest = t;
        t = sqrtf(dot(n, n)) * (dot(n, ray) > 0 ? -1.0f : 1.0f);
        for (k = 0; k < 3; k++) {
            to->positions[3 * pixel + k] = eye[k] + nearest * ray[k];
            to->normals[3 * pixel + k] = n[k] / t;
            to->albedo[3 * pixel + k] = colors[q][k];
        }
    }
}

/* Draws what a matrix of the map sees. Its rows are the directions in which x, y and w grow. */
static void draw_face(const float clip[16], const float *eye)
{
    int pixel, k;
    for (pixel = 0; pixel < SIDE * SIDE; pixel++) {
        const float x = ((float)(pixel % SIDE) + 0.5f) / SIDE * 2 - 1;
        const float y = ((float)(pixel / SIDE) + 0.5f) / SIDE * 2 - 1;
        float ray[3], right2 = 0, up2 = 0;
        for (k = 0; k < 3; k++) right2 += clip[4 * k] * clip[4 * k], up2 += clip[4 * k + 1] * clip[4 * k + 1];
        for (k = 0; k < 3; k++) ray[k] = clip[4 * k + 3] + clip[4 * k] * x / right2 + clip[4 * k + 1] * y / up2;
        draw_pixel(&drawn, pixel, eye, ray);
    }
}

/* ---- the lamp ---- */

/* Empties the map, moves its lamp and draws all its faces anew. */
static rsm_result draw_map(rsm_map *map, rsm_light *lamp, int frame)
{
    rsm_buffers faces = { 0 };
    rsm_info info;
    rsm_result result;
    float clip[16];
    uint32_t face;
    lamp->position[0] = -1.2f + 0.8f * (float)frame;
    lamp->position[1] = 1.8f, lamp->position[2] = 0.9f;
    result = rsm_map_restart(map, lamp);
    rsm_get_info(map, &info);
    faces.positions = drawn.positions;
    faces.normals = drawn.normals;
    faces.albedo = drawn.albedo;
    for (face = 0; result == RSM_OK && face < info.face_count; face++) {
        result = rsm_map_matrix(map, face, clip);
        if (result != RSM_OK) break;
        draw_face(clip, lamp->position);
        result = rsm_fill(map, face, &faces);
    }
    return result == RSM_OK ? rsm_finish(map, NULL) : result;
}

/* Whether the lamp sees a point: its texel there is not much nearer. */
static int lamp_sees(const rsm_map *map, const float *point)
{
    float uv[2], depth;
    uint32_t face, x, y;
    if (rsm_map_project(map, point, &face, uv, &depth) != RSM_OK || !(depth > 0)) return 0;
    x = (uint32_t)(uv[0] * SIDE) < SIDE ? (uint32_t)(uv[0] * SIDE) : SIDE - 1;
    y = (uint32_t)(uv[1] * SIDE) < SIDE ? (uint32_t)(uv[1] * SIDE) : SIDE - 1;
    return depth < rsm_map_texels(map)[(face * SIDE + y) * SIDE + x].depth + 0.1f;
}

/* Lights the camera's picture by the map alone; *clusters area lights stand for all that bounces. */
static rsm_result shade(const rsm_map *map, size_t *clusters)
{
    static rsm_texel lights[LIGHTS], areas[CLUSTERS];
    rsm_gather_desc gather = { 0 };
    rsm_points points = { 0 };
    size_t count;
    rsm_result result = rsm_pixel_lights(&map, 1, LIGHTS, 1, lights, LIGHTS, &count);
    points.count = PIXELS;
    points.positions = seen.positions;
    points.normals = seen.normals;
    gather.near_limit = 0.3f;
    if (result == RSM_OK) result = rsm_cluster(lights, count, CLUSTERS, NULL, areas, clusters);
    if (result == RSM_OK) result = rsm_gather_list(areas, *clusters, &gather, &points, bounce, NULL);
    return result == RSM_OK ? rsm_direct(map, NULL, &points, light) : result;
}

int main(int count, char **values)
{
    static const float eye[3] = { 0, 1.4f, 5.5f }, beside[3] = { 0.9f, 0, -0.1f };
    FILE *file = fopen(count > 1 ? values[1] : "swing.ppm", "wb");
    rsm_desc desc = { 0 };
    rsm_map *map;
    int frame, i, k;

    desc.light.kind = RSM_LIGHT_POINT;
    desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 4;
    desc.side = SIDE;
    if (!file || rsm_map_create(&desc, &map) != RSM_OK)
        return fprintf(stderr, "cannot write the picture, or out of memory\n"), 1;
    for (i = 0; i < PIXELS; i++) {
        float ray[3] = { 0, 0, -1.2f };
        ray[0] = ((float)(i % WIDTH) + 0.5f - WIDTH / 2) / HEIGHT;
        ray[1] = (HEIGHT / 2 - (float)(i / WIDTH) - 0.5f) / HEIGHT;
        draw_pixel(&seen, i, eye, ray);
    }
    for (frame = 0; frame < FRAMES; frame++) {
        size_t clusters;
        rsm_result result = draw_map(map, &desc.light, frame);
        if (result == RSM_OK) result = shade(map, &clusters);
        if (result != RSM_OK) return fprintf(stderr, "frame %d: %s\n", frame, rsm_result_text(result)), 1;
        printf("frame %d: %u area lights; the lamp %s the floor right of the block\n", frame, (unsigned)clusters,
               lamp_sees(map, beside) ? "sees" : "does not see");
        for (i = 0; i < 3 * PIXELS; i++) {
            float radiance = seen.albedo[i] * (light[i] + bounce[i]) / 3.14159265f;
            picture[frame][i] = (unsigned char)(255 * powf(radiance < 1 ? radiance : 1, 1 / 2.2f) + 0.5f);
        }
    }
    fprintf(file, "P6 %d %d 255\n", FRAMES * WIDTH, HEIGHT);
    for (i = 0; i < HEIGHT; i++)
        for (k = 0; k < FRAMES; k++) fwrite(picture[k] + 3 * WIDTH * i, 3, WIDTH, file);
    rsm_map_free(map);
    return fclose(file) != 0;
}
