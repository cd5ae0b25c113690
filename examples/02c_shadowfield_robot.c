/* 02c_shadowfield_robot.c - a walking robot of rigid parts that hide light from each other, with shadowfield.h and
   nothing else.

   cc -O2 02c_shadowfield_robot.c -lm -o robot && ./robot walk.ppm

   Twelve parts of three meshes: a trunk and two feet, a head, and eight limbs that are one mesh in two sizes. Each part
   is an entity. Its points have the number of that entity, so that its field does not hide them, and have the
   self-visibility of their mesh in its place; the other eleven parts hide light from them by their fields. Nothing but
   the transforms changes from frame to frame. The picture shows four frames of a step side by side, under a lamp and a
   sky. */
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES = 4, WIDTH = 200, HEIGHT = 320 };
enum { ROWS = 28, COLUMNS = 24, VERTICES = (ROWS + 1) * COLUMNS, TRIANGLES = 2 * ROWS * COLUMNS };
enum { TRUNK, HEAD, LIMB, MESHES, PARTS = 12, GRID = 96 };

/* The lamp where it hangs. */
static const sfield_entity shining = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1.5f, 2.5f, 0.5f, 1 },
                                       { 1, 1, 1 }, 0 };

static const float pi = 3.14159265f;

typedef struct part_mesh {          /* what all parts of one shape have in common */
    float    positions[3 * VERTICES], normals[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    sfield_field *occlusion, *self;
} part_mesh;

typedef struct picture {
    float depth[FRAMES * WIDTH * HEIGHT];
    unsigned char rgb[3 * FRAMES * WIDTH * HEIGHT];
} picture;

/* ---- meshes ---- */

/* A limb goes from the joint at the origin to (0, -1, 0) and is round at both ends; the trunk is a rounded box about
   the origin, the head a ball. v goes from the top to the bottom, u round the y axis. All are closed: a part's field is
   asked close to its surface, and knows which of its sample points lie inside of a closed mesh alone. */
static void shape(int mesh, float u, float v, float *p)
{
    static const float half[MESHES][3] = { { 0.28f, 0.36f, 0.17f }, { 0.15f, 0.17f, 0.16f }, { 0.19f, 0.19f, 0.19f } };
    const float along = fminf(fmaxf(2 * v - 0.5f, 0), 1), cap = v < 0.25f ? 2 * v : v > 0.75f ? 2 * v - 1 : 0.5f;
    const float at = mesh == LIMB ? cap : v, r = v > 0 && v < 1 ? sinf(pi * at) : 0;
    const float x = r * cosf(u), y = cosf(pi * at), z = r * sinf(u);
    const float box = mesh == TRUNK ? powf(x * x * x * x + y * y * y * y + z * z * z * z, -0.25f) : 1;
    p[0] = half[mesh][0] * box * x;
    p[1] = half[mesh][1] * box * y - (mesh == LIMB ? along : 0);
    p[2] = half[mesh][2] * box * z;
}

/* Normals of vertices from those of the triangles round them. */
static void make_normals(part_mesh *m)
{
    for (int t = 0; t < TRIANGLES; t++) {
        const uint32_t *i = m->indices + 3 * t;
        const float *a = m->positions + 3 * i[0], *b = m->positions + 3 * i[1], *c = m->positions + 3 * i[2];
        for (int k = 0; k < 3; k++) {
            const int q = (k + 1) % 3, r = (k + 2) % 3;
            const float n = (b[q] - a[q]) * (c[r] - a[r]) - (b[r] - a[r]) * (c[q] - a[q]);
            for (int v = 0; v < 3; v++) m->normals[3 * i[v] + (uint32_t)k] += n;
        }
    }
    for (int v = 0; v < VERTICES; v++) {
        float *n = m->normals + 3 * v, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++) n[k] /= length;
    }
}

static sfield_result make_mesh(part_mesh *m, int which)
{
    uint32_t *i = m->indices;
    const sfield_mesh mesh = { m->positions, VERTICES, 0, m->indices, 3 * TRIANGLES, NULL, NULL, NULL };
    sfield_points points;
    sfield_desc desc;
    sfield_result result;
    for (uint32_t row = 0; row <= ROWS; row++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            const uint32_t a = row * COLUMNS + column, b = row * COLUMNS + (column + 1) % COLUMNS;
            shape(which, 2 * pi * (float)column / COLUMNS, (float)row / ROWS, m->positions + 3 * a);
            if (row == ROWS) continue;
            *i++ = a, *i++ = b, *i++ = b + COLUMNS;
            *i++ = a, *i++ = b + COLUMNS, *i++ = a + COLUMNS;
        }
    make_normals(m);
    memset(&points, 0, sizeof points);
    points.count = VERTICES;
    points.positions = m->positions;
    points.normals = m->normals;
    memset(&desc, 0, sizeof desc);
    desc.position_side = 12;
    result = sfield_build(&desc, &mesh, &m->occlusion, NULL);
    return result != SFIELD_OK ? result : sfield_build_self(&desc, &mesh, &points, 0.002f, &m->self, NULL);
}

/* ---- the walk ---- */

/* A part's matrix: as its parent's, then moved to the joint, turned about x and scaled. */
static void join(const float *parent, float x, float y, float z, float angle, float scale, float *m)
{
    const float c = scale * cosf(angle), s = scale * sinf(angle);
    for (int k = 0; k < 4; k++) {
        m[k] = scale * parent[k];
        m[4 + k] = c * parent[4 + k] + s * parent[8 + k];
        m[8 + k] = c * parent[8 + k] - s * parent[4 + k];
        m[12 + k] = x * parent[k] + y * parent[4 + k] + z * parent[8 + k] + parent[12 + k];
    }
}

/* Two limbs with a joint between them, and at a leg's end a foot that stays level. */
static void pose_limbs(sfield_entity *out, const float *trunk, float x, float y, float size, float swing, float bend,
                       int foot)
{
    float level[16];
    join(trunk, x, y, 0, swing, size, out[0].transform);
    join(out[0].transform, 0, -1, 0, bend, 1, out[1].transform);
    join(out[1].transform, 0, -1, 0, -swing - bend, 1 / size, level);
    if (foot) join(level, 0, -0.028f, 0.08f, pi / 2, 0.36f, out[2].transform);
}

/* All parts at a time of the step, 0..1. The robot looks to +z; a positive angle takes a limb's end backwards. */
static void walk(sfield_entity *entity, float phase)
{
    const float thigh = 0.46f, hips = -0.34f, a = 2 * pi * phase;
    float trunk[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    float swing[2], bend[2], reach = 0;
    for (int side = 0; side < 2; side++) {
        const float b = a + pi * (float)side;
        swing[side] = -0.5f * sinf(b);
        bend[side] = 0.15f + 0.75f * fmaxf(cosf(b), 0);
        reach = fmaxf(reach, thigh * (cosf(swing[side]) + cosf(swing[side] + bend[side])));
    }
    trunk[13] = reach - hips + 0.09f;
    join(trunk, 0, 0, 0, 0, 1, entity[0].transform);
    join(trunk, 0, 0.56f, 0.02f, 0, 1, entity[1].transform);
    for (int side = 0; side < 2; side++) {
        const float x = side ? -1.0f : 1.0f;
        pose_limbs(entity + 2 + 2 * side, trunk, 0.36f * x, 0.26f, 0.34f, -swing[side], -0.5f, 0);
        pose_limbs(entity + 6 + 3 * side, trunk, 0.15f * x, hips, thigh, swing[side], bend[side], 1);
    }
}

static int mesh_of(int part) { return part == 0 || part == 8 || part == 11 ? TRUNK : part == 1 ? HEAD : LIMB; }

/* ---- drawing: what a GPU would do with the light of each vertex ---- */

static void project(const float *p, float *out)
{
    const float x = p[0] * 0.82f - p[2] * 0.57f, z = p[0] * 0.57f + p[2] * 0.82f, y = p[1] - 0.92f;
    const float depth = 5.2f - 0.96f * z - 0.28f * y, focal = 1.6f * HEIGHT;
    out[0] = WIDTH / 2.0f + focal * x / depth;
    out[1] = HEIGHT / 2.0f - focal * (0.96f * y - 0.28f * z) / depth;
    out[2] = depth;
}

static void draw_triangle(picture *out, int frame, const float *const *p, const float *const *rgb, const float *albedo)
{
    float v[3][3], area;
    for (int i = 0; i < 3; i++) project(p[i], v[i]);
    area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
    if (fabsf(area) < 1e-6f) return;
    for (int y = (int)fmaxf(fminf(v[0][1], fminf(v[1][1], v[2][1])), 0); y < HEIGHT; y++) {
        if ((float)y > fmaxf(v[0][1], fmaxf(v[1][1], v[2][1]))) break;
        for (int x = (int)fmaxf(fminf(v[0][0], fminf(v[1][0], v[2][0])), 0); x < WIDTH; x++) {
            const float px = (float)x + 0.5f, py = (float)y + 0.5f;
            const int at = (y * FRAMES + frame) * WIDTH + x;
            float w[3], depth = 0;
            if ((float)x > fmaxf(v[0][0], fmaxf(v[1][0], v[2][0]))) break;
            for (int i = 0; i < 3; i++) {
                const float *a = v[(i + 1) % 3], *b = v[(i + 2) % 3];
                w[i] = ((a[0] - px) * (b[1] - py) - (a[1] - py) * (b[0] - px)) / area;
                depth += w[i] * v[i][2];
            }
            if (w[0] < 0 || w[1] < 0 || w[2] < 0 || depth >= out->depth[at]) continue;
            out->depth[at] = depth;
            for (int k = 0; k < 3; k++) {
                const float l = albedo[k] * (w[0] * rgb[0][k] + w[1] * rgb[1][k] + w[2] * rgb[2][k]);
                out->rgb[3 * at + k] = (unsigned char)(255 * powf(fminf(fmaxf(l, 0), 1), 1 / 2.2f) + 0.5f);
            }
        }
    }
}

/* transform NULL: positions are in the world. */
static void draw(picture *out, int frame, const sfield_points *points, const uint32_t *indices, int count,
                 const float *transform, const float *albedo)
{
    float world[3][3];
    const float *p[3] = { world[0], world[1], world[2] }, *rgb[3];
    for (int t = 0; t < count; t++) {
        for (int v = 0; v < 3; v++) {
            const uint32_t i = indices[3 * t + v];
            const float *q = points->positions + 3 * i, *m = transform;
            for (int k = 0; k < 3; k++)
                world[v][k] = m ? m[k] * q[0] + m[4 + k] * q[1] + m[8 + k] * q[2] + m[12 + k] : q[k];
            rgb[v] = points->rgb + 3 * i;
        }
        draw_triangle(out, frame, p, rgb, albedo);
    }
}

/* ---- the program ---- */

static sfield_result make_scene(part_mesh *mesh, sfield_entity *entities, sfield_points *sets, sfield_scene **scene,
                                sfield_field **light)
{
    static const float sky[2 * 3] = { 0.30f, 0.36f, 0.46f, 0.10f, 0.09f, 0.08f };   /* the upper half, the lower */
    static float rgb[PARTS][3 * VERTICES];
    sfield_emitter lamp;
    sfield_result result = SFIELD_OK;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 0.35f;
    lamp.radiance[0] = 50, lamp.radiance[1] = 42, lamp.radiance[2] = 32;
    for (int i = 0; i < MESHES && result == SFIELD_OK; i++) result = make_mesh(&mesh[i], i);
    if (result == SFIELD_OK) result = sfield_build_emitter(NULL, &lamp, light, NULL);
    if (result == SFIELD_OK) result = sfield_scene_create(NULL, scene);
    if (result == SFIELD_OK) result = sfield_scene_environment(*scene, sky, 1, 2, NULL);
    for (int i = 0; i < PARTS; i++) {
        const part_mesh *m = &mesh[mesh_of(i)];
        entities[i].occlusion = m->occlusion;
        sets[i].count = VERTICES;
        sets[i].positions = m->positions;
        sets[i].normals = m->normals;
        sets[i].entity = (uint32_t)i + 1;       /* these points lie on part i, which its own field ... */
        sets[i].self = m->self;                 /* ... does not hide: their self-visibility does */
        sets[i].rgb = rgb[i];
    }
    entities[PARTS] = shining;
    entities[PARTS].source = *light;
    return result;
}

static void make_floor(sfield_points *set, uint32_t *indices)
{
    static float positions[3 * GRID * GRID], normals[3 * GRID * GRID], rgb[3 * GRID * GRID];
    for (uint32_t y = 0; y < GRID; y++)
        for (uint32_t x = 0; x < GRID; x++) {
            const uint32_t i = y * GRID + x;
            positions[3 * i] = 9 * (float)x / GRID - 6;
            positions[3 * i + 2] = 9 * (float)y / GRID - 6;
            normals[3 * i + 1] = 1;
            if (x + 1 == GRID || y + 1 == GRID) continue;
            *indices++ = i, *indices++ = i + GRID, *indices++ = i + 1;
            *indices++ = i + 1, *indices++ = i + GRID, *indices++ = i + GRID + 1;
        }
    memset(set, 0, sizeof *set);
    set->count = GRID * GRID;
    set->positions = positions;
    set->normals = normals;
    set->rgb = rgb;
}

int main(int count, char **values)
{
    static const float albedo[4][3] = { { 0.75f, 0.35f, 0.12f }, { 0.6f, 0.6f, 0.62f }, { 0.55f, 0.58f, 0.62f },
                                        { 0.6f, 0.6f, 0.58f } };
    static part_mesh mesh[MESHES];
    static picture out;
    static uint32_t floor_indices[6 * (GRID - 1) * (GRID - 1)];
    sfield_entity entities[PARTS + 1];
    sfield_points sets[PARTS + 1];
    sfield_scene *scene = NULL;
    sfield_field *light = NULL;
    sfield_result result;
    double spent = 0;
    FILE *file;
    memset(entities, 0, sizeof entities);
    memset(sets, 0, sizeof sets);
    result = make_scene(mesh, entities, sets, &scene, &light);
    make_floor(&sets[PARTS], floor_indices);
    for (int i = 0; i < FRAMES * WIDTH * HEIGHT; i++) {
        out.depth[i] = 1e9f;
        out.rgb[3 * i] = 148, out.rgb[3 * i + 1] = 160, out.rgb[3 * i + 2] = 179;       /* the sky */
    }
    for (int frame = 0; frame < FRAMES && result == SFIELD_OK; frame++) {
        const clock_t start = clock();
        walk(entities, (float)frame / FRAMES);
        result = sfield_scene_entities(scene, entities, PARTS + 1);
        if (result == SFIELD_OK) result = sfield_shade(scene, sets, PARTS + 1, NULL);
        spent += 1000.0 * (double)(clock() - start) / CLOCKS_PER_SEC;
        for (int i = 0; i < PARTS && result == SFIELD_OK; i++)
            draw(&out, frame, &sets[i], mesh[mesh_of(i)].indices, TRIANGLES, entities[i].transform, albedo[mesh_of(i)]);
        draw(&out, frame, &sets[PARTS], floor_indices, 2 * (GRID - 1) * (GRID - 1), NULL, albedo[MESHES]);
    }
    if (result != SFIELD_OK) return fprintf(stderr, "robot: %s\n", sfield_result_text(result)), 1;
    printf("%d points on %d parts and %d on the floor: %.1f ms a frame\n", PARTS * VERTICES, PARTS, GRID * GRID,
           spent / FRAMES);
    file = fopen(count > 1 ? values[1] : "walk.ppm", "wb");
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    fprintf(file, "P6 %d %d 255\n", FRAMES * WIDTH, HEIGHT);
    fwrite(out.rgb, 1, sizeof out.rgb, file);
    sfield_scene_free(scene);
    sfield_free(light);
    for (int i = 0; i < MESHES; i++) {
        sfield_free(mesh[i].occlusion);
        sfield_free(mesh[i].self);
    }
    return fclose(file) != 0;
}
