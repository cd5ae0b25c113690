/* 01h_csm_skinned.c - shadows of a figure whose limbs bend, by maps of its rigid parts, with csm.h and nothing else.

   cc -O2 01h_csm_skinned.c -lm -o skinned && ./skinned step.ppm

   Maps are of what does not change its shape. A limb is a skin over two bones, which bends at its middle: each bone has
   maps of its half of the skin as it is when straight, and is an instance that moves. A point is asked for where its
   own bone alone would take it, so that it lies on the surface that the maps have seen. Halves overlap, lest light
   falls through a bent knee. Trunk and head are rigid: ten instances of four maps.

   The picture shows four frames of a step under a sky and a sun. The program then says how far the sky's light is from
   that of rays that meet the skin itself: on straight limbs, where it is maps alone that differ, and on bent ones. */
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES = 4, WIDTH = 200, HEIGHT = 320, ROWS = 40, COLUMNS = 24, VERTICES = (ROWS + 1) * COLUMNS,
       TRIANGLES = 2 * ROWS * COLUMNS };
enum { TRUNK, HEAD, UPPER, LOWER, SHAPES, SKINS = 6, BONES = 10, GRID = 96, FLOOR = GRID * GRID, SKY = 96 };

static const float pi = 3.14159265f, bend_half = 0.22f;     /* the skin bends so far from a joint, in bones' lengths */
static const float half[3][3] = { { 0.28f, 0.36f, 0.17f }, { 0.15f, 0.17f, 0.16f }, { 0.19f, 0.19f, 0.19f } };
static const float sun[3] = { 0.55f, 0.72f, 0.42f };

/* A shape of the figure: trunk, head or a straight limb, from its joint at the origin to (0, -2, 0). */
typedef struct shape { float positions[3 * VERTICES], lower[VERTICES]; uint32_t indices[3 * TRIANGLES]; } shape;

/* What is drawn in a frame. A vertex is asked where its bone alone takes it, and drawn where the skin does. */
typedef struct skin {
    float    asked[3 * VERTICES], drawn[3 * VERTICES], normals[3 * VERTICES], rgb[3 * VERTICES];
    uint32_t entity[VERTICES];
} skin;

typedef struct figure {
    cohsm_maps    *maps[SHAPES];
    cohsm_instance bone[BONES];
    skin           skins[SKINS];
    float          floor[3 * FLOOR], floor_normals[3 * FLOOR], floor_rgb[3 * FLOOR];
    uint32_t       floor_indices[6 * (GRID - 1) * (GRID - 1)];
    float          sky[3 * SKY];
} figure;

static shape shapes[3];             /* trunk, head, limb */
static figure f;
static float depths[FRAMES * WIDTH * HEIGHT];
static unsigned char picture[3 * FRAMES * WIDTH * HEIGHT];

/* ---- vectors ---- */

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void minus(const float *a, const float *b, float *out)
{
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

static void cross(const float *a, const float *b, float *out)
{
    for (int k = 0; k < 3; k++) {
        const int q = (k + 1) % 3, r = (k + 2) % 3;
        out[k] = a[q] * b[r] - a[r] * b[q];
    }
}

/* ---- shapes and their maps ---- */

/* u goes round the y axis, v from top to bottom. lower: how far a vertex belongs to the limb's lower bone. */
static void make_shape(shape *s, int which)
{
    uint32_t *i = s->indices;
    for (uint32_t row = 0; row <= ROWS; row++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            const uint32_t a = row * COLUMNS + column, b = row * COLUMNS + (column + 1) % COLUMNS;
            const float u = 2 * pi * (float)column / COLUMNS, v = (float)row / ROWS;
            const float cap = v < 0.15f ? v / 0.3f : v > 0.85f ? (v - 0.7f) / 0.3f : 0.5f, at = which == 2 ? cap : v;
            const float r = row > 0 && row < ROWS ? sinf(pi * at) : 0, x = r * cosf(u), y = cosf(pi * at);
            const float z = r * sinf(u), fourth = x * x * x * x + y * y * y * y + z * z * z * z;
            const float box = which == TRUNK ? powf(fourth, -0.25f) : 1;
            const float along = which == 2 ? 2 * fminf(fmaxf((v - 0.15f) / 0.7f, 0), 1) : 0;
            const float t = fminf(fmaxf(0.5f + (along - 1) / (2 * bend_half), 0), 1);
            float *p = s->positions + 3 * a;
            p[0] = half[which][0] * box * x;
            p[1] = half[which][1] * box * y - along;
            p[2] = half[which][2] * box * z;
            s->lower[a] = t * t * (3 - 2 * t);
            if (row == ROWS) continue;
            *i++ = a, *i++ = b, *i++ = b + COLUMNS;
            *i++ = a, *i++ = b + COLUMNS, *i++ = a + COLUMNS;
        }
}

/* Maps of a shape, or of the triangles of a limb that its upper bone moves, or its lower one. */
static cohsm_result make_maps(int which, cohsm_maps **out)
{
    const float overlap = 0.15f;    /* triangles are the other bone's, too, to which they belong by so much */
    const shape *s = &shapes[which < 2 ? which : 2];
    static uint32_t kept[3 * TRIANGLES];
    cohsm_mesh mesh;
    cohsm_desc desc;
    memset(&mesh, 0, sizeof mesh);
    memset(&desc, 0, sizeof desc);
    for (int t = 0; t < TRIANGLES; t++) {
        const uint32_t *i = s->indices + 3 * t;
        const float w = (s->lower[i[0]] + s->lower[i[1]] + s->lower[i[2]]) / 3;
        if ((which == UPPER && w > 1 - overlap) || (which == LOWER && w < overlap)) continue;
        memcpy(kept + mesh.index_count, i, 3 * sizeof *i);
        mesh.index_count += 3;
    }
    mesh.positions = s->positions;
    mesh.vertex_count = VERTICES;
    mesh.indices = kept;
    desc.domain.side[0] = desc.domain.side[1] = 48;
    desc.map_side = 96;
    return cohsm_build(&desc, &mesh, out, NULL);
}

/* ---- the step ---- */

/* A bone's matrix: as its parent's, then moved to the joint, turned about x and scaled. */
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

/* The lower bone of a limb, which turns at the limb's middle; like the upper one it moves the straight limb. */
static void join_lower(const float *upper, float angle, float *m)
{
    float turned[16];
    join(upper, 0, -1, 0, angle, 1, turned);
    join(turned, 0, 1, 0, 0, 1, m);
}

/* All bones; bend: 0 = straight limbs, 1 = a step at a phase 0..1. The figure looks to +z. */
static void pose(cohsm_instance *bone, float phase, float bend)
{
    static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const float thigh = 0.46f, hips = -0.3f;
    float swing[2], knee[2], reach = 0, trunk[16];
    for (int side = 0; side < 2; side++) {
        const float a = 2 * pi * phase + pi * (float)side;
        swing[side] = -0.6f * bend * sinf(a);
        knee[side] = bend * (0.2f + 0.9f * fmaxf(cosf(a), 0));
        reach = fmaxf(reach, thigh * (cosf(swing[side]) + cosf(swing[side] + knee[side])));
    }
    join(unit, 0, reach - hips + 0.19f * thigh, 0, 0, 1, trunk);
    memcpy(bone[0].transform, trunk, sizeof trunk);
    join(trunk, 0, 0.54f, 0.02f, 0, 1, bone[1].transform);
    for (int side = 0; side < 2; side++) {
        const float x = side ? -1.0f : 1.0f;
        float *arm = bone[2 + 2 * side].transform, *leg = bone[6 + 2 * side].transform;
        join(trunk, 0.37f * x, 0.24f, 0, -swing[side] - 0.1f * bend, 0.34f, arm);
        join_lower(arm, -0.9f * bend, bone[3 + 2 * side].transform);
        join(trunk, 0.14f * x, hips, 0, swing[side], thigh, leg);
        join_lower(leg, knee[side], bone[7 + 2 * side].transform);
    }
}

static void transform(const float *m, const float *p, float *out)
{
    for (int k = 0; k < 3; k++) out[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

/* Skins 0 and 1 are trunk and head, 2..5 the limbs, whose bones are 2 n - 2 and 2 n - 1. */
static void bend_skin(skin *out, const cohsm_instance *bone, int n)
{
    const shape *s = &shapes[n < 2 ? n : 2];
    const int upper = n < 2 ? n : 2 * n - 2, lower = n < 2 ? n : upper + 1;
    memset(out->normals, 0, sizeof out->normals);
    for (int v = 0; v < VERTICES; v++) {
        const float *p = s->positions + 3 * v, w = s->lower[v];
        float a[3], b[3];
        transform(bone[upper].transform, p, a);
        transform(bone[lower].transform, p, b);
        memcpy(out->asked + 3 * v, w < 0.5f ? a : b, sizeof a);
        out->entity[v] = (uint32_t)(w < 0.5f ? upper : lower) + 1;
        for (int k = 0; k < 3; k++) out->drawn[3 * v + k] = a[k] + w * (b[k] - a[k]);
    }
    for (int t = 0; t < TRIANGLES; t++) {
        const uint32_t *i = s->indices + 3 * t;
        const float *a = out->drawn + 3 * i[0], *b = out->drawn + 3 * i[1], *c = out->drawn + 3 * i[2];
        float ab[3], ac[3], area[3];
        minus(b, a, ab);
        minus(c, a, ac);
        cross(ab, ac, area);
        for (int v = 0; v < 3; v++)
            for (uint32_t k = 0; k < 3; k++) out->normals[3 * i[v] + k] += area[k];
    }
    for (int v = 0; v < VERTICES; v++) {
        float *m = out->normals + 3 * v, length = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        for (int k = 0; k < 3; k++) m[k] /= fmaxf(length, 1e-12f);
    }
}

/* ---- light ---- */

/* Adds one direction's light to points where they see it. entity NULL: they lie on no bone. */
static cohsm_result shine(const float *positions, const float *normals, const uint32_t *entity, size_t count,
                          const float *direction, const float *rgb, cohsm_filter filter, float *out)
{
    static float visible[FLOOR + VERTICES];
    cohsm_query query;
    cohsm_result result;
    memset(&query, 0, sizeof query);
    query.count = count;
    query.positions = positions;
    query.lights = direction;
    query.one_light = 1;
    query.filter = filter;
    query.entities = entity;
    result = cohsm_visible_scene(f.bone, BONES, &query, visible, NULL);
    for (size_t i = 0; i < count && result == COHSM_OK; i++)
        for (size_t k = 0; k < 3; k++)
            out[3 * i + k] += rgb[k] * visible[i] * fmaxf(dot(normals + 3 * i, direction), 0);
    return result;
}

static cohsm_result light_frame(void)
{
    static const float sun_rgb[3] = { 0.75f, 0.68f, 0.55f };
    const float sky_rgb[3] = { 0.62f / SKY, 0.72f / SKY, 0.9f / SKY };
    cohsm_result result = COHSM_OK;
    memset(f.floor_rgb, 0, sizeof f.floor_rgb);
    for (int n = 0; n < SKINS; n++) memset(f.skins[n].rgb, 0, sizeof f.skins[n].rgb);
    for (int i = -1; i < SKY && result == COHSM_OK; i++) {
        const float *direction = i < 0 ? sun : f.sky + 3 * i, *rgb = i < 0 ? sun_rgb : sky_rgb;
        const cohsm_filter filter = i < 0 ? COHSM_FILTER_PCF : COHSM_FILTER_NEAREST;
        result = shine(f.floor, f.floor_normals, NULL, FLOOR, direction, rgb, filter, f.floor_rgb);
        for (int n = 0; n < SKINS && result == COHSM_OK; n++) {
            skin *s = &f.skins[n];
            result = shine(s->asked, s->normals, s->entity, VERTICES, direction, rgb, filter, s->rgb);
        }
    }
    return result;
}

/* ---- beside rays that meet the skin itself ---- */

/* Möller and Trumbore 1997. */
static int meets_triangle(const float *from, const float *d, const float *a, const float *b, const float *c)
{
    float e[3], g[3], s[3];
    float h[3], q[3], det, u;
    minus(b, a, e);
    minus(c, a, g);
    minus(from, a, s);
    cross(d, g, h);
    cross(s, e, q);
    det = dot(e, h);
    u = dot(s, h) / det;
    return u >= 0 && dot(d, q) / det >= 0 && u + dot(d, q) / det <= 1 && dot(g, q) / det > 0;
}

/* How often a ray meets a skin. */
static int crossings(int n, const float *from, const float *d)
{
    const float *p = f.skins[n].drawn;
    int count = 0;
    for (int t = 0; t < TRIANGLES; t++) {
        const uint32_t *i = shapes[n < 2 ? n : 2].indices + 3 * t;
        count += meets_triangle(from, d, p + 3 * i[0], p + 3 * i[1], p + 3 * i[2]);
    }
    return count;
}

/* Does a point lie inside of another skin than its own? Nobody sees it then. */
static int is_inside(int own, const float *from)
{
    int inside = 0;
    for (int n = 0; n < SKINS; n++) inside |= n != own && crossings(n, from, f.sky) % 2 != 0;
    return inside;
}

typedef struct mean { double sum; size_t count; } mean;

/* The light of an even sky: adds the difference between maps and rays, in parts of what open ground has. own: the skin
   that the point lies on, or -1: the floor. */
static cohsm_result compare(const float *asked, const float *drawn, const float *n, const uint32_t *entity, int own,
                            mean *off)
{
    cohsm_result result = COHSM_OK;
    float from[3], maps = 0, rays = 0;
    for (int k = 0; k < 3; k++) from[k] = drawn[k] + 0.004f * n[k];
    if (is_inside(own, from)) return COHSM_OK;
    for (int j = 0; j < SKY && result == COHSM_OK; j++) {
        const float cosine = dot(n, f.sky + 3 * j);
        int hidden = 0;
        cohsm_query query;
        float visible = 0;
        if (cosine <= 0) continue;
        memset(&query, 0, sizeof query);
        query.count = 1;
        query.positions = asked;
        query.lights = f.sky + 3 * j;
        query.entities = entity;
        result = cohsm_visible_scene(f.bone, BONES, &query, &visible, NULL);
        for (int i = 0; i < SKINS && !hidden; i++) hidden = crossings(i, from, f.sky + 3 * j) > 0;
        maps += cosine * visible;
        rays += hidden ? 0 : cosine;
    }
    off->sum += fabs((double)(maps - rays)) / (SKY / 2.0);
    off->count++;
    return result;
}

static cohsm_result compare_all(float bend)
{
    mean off[3] = { { 0, 0 }, { 0, 0 }, { 0, 0 } };     /* the floor, where the skin bends, the rest of the figure */
    cohsm_result result = COHSM_OK;
    pose(f.bone, 0.15f, bend);
    for (int n = 0; n < SKINS; n++) bend_skin(&f.skins[n], f.bone, n);
    for (int i = 0; i < FLOOR && result == COHSM_OK; i += 61)
        result = compare(f.floor + 3 * i, f.floor + 3 * i, f.floor_normals + 3 * i, NULL, -1, &off[0]);
    for (int n = 0; n < SKINS; n++)
        for (int i = 0; i < VERTICES && result == COHSM_OK; i += 17) {
            const skin *s = &f.skins[n];
            const float w = n < 2 ? 0 : shapes[2].lower[i];
            result = compare(s->asked + 3 * i, s->drawn + 3 * i, s->normals + 3 * i, s->entity + i, n,
                             &off[w > 0 && w < 1 ? 1 : 2]);
        }
    printf("%s limbs: light of the sky off by %.4f on the floor, %.4f where limbs bend, %.4f elsewhere\n",
           bend > 0 ? "bent" : "straight", off[0].sum / (double)off[0].count, off[1].sum / (double)off[1].count,
           off[2].sum / (double)off[2].count);
    return result;
}

/* ---- drawing: what a GPU would do with the light of each vertex ---- */

static void project(const float *p, float *out)
{
    const float x = p[0] * 0.82f - p[2] * 0.57f, z = p[0] * 0.57f + p[2] * 0.82f, y = p[1] - 0.92f;
    const float depth = 5.2f - 0.96f * z - 0.28f * y, focal = 1.6f * HEIGHT;
    out[0] = WIDTH / 2.0f + focal * x / depth;
    out[1] = HEIGHT / 2.0f - focal * (0.96f * y - 0.28f * z) / depth;
    out[2] = depth;
}

/* One triangle: its corners on the screen, and their light. */
static void draw_triangle(int frame, float v[3][3], const float *const *rgb, const float *albedo)
{
    const float area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
    const int left = (int)fmaxf(fminf(v[0][0], fminf(v[1][0], v[2][0])), 0);
    const int top = (int)fmaxf(fminf(v[0][1], fminf(v[1][1], v[2][1])), 0);
    const int right = (int)fminf(fmaxf(v[0][0], fmaxf(v[1][0], v[2][0])), WIDTH - 1);
    const int bottom = (int)fminf(fmaxf(v[0][1], fmaxf(v[1][1], v[2][1])), HEIGHT - 1);
    for (int y = top; y <= bottom; y++)
        for (int x = left; x <= right; x++) {
            const float px = (float)x + 0.5f, py = (float)y + 0.5f;
            const int at = (y * FRAMES + frame) * WIDTH + x;
            float w[3], depth = 0;
            for (int i = 0; i < 3; i++) {
                const float *a = v[(i + 1) % 3], *b = v[(i + 2) % 3];
                w[i] = ((a[0] - px) * (b[1] - py) - (a[1] - py) * (b[0] - px)) / area;
                depth += w[i] * v[i][2];
            }
            if (!(w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && depth < depths[at])) continue;
            depths[at] = depth;
            for (int k = 0; k < 3; k++) {
                const float light = albedo[k] * (w[0] * rgb[0][k] + w[1] * rgb[1][k] + w[2] * rgb[2][k]);
                picture[3 * at + k] = (unsigned char)(255 * powf(fminf(light, 1), 1 / 2.2f) + 0.5f);
            }
        }
}

static void draw(int frame, const float *positions, const float *rgb, const uint32_t *indices, int count,
                 const float *albedo)
{
    for (int t = 0; t < count; t++) {
        const uint32_t *i = indices + 3 * t;
        const float *light[3] = { rgb + 3 * i[0], rgb + 3 * i[1], rgb + 3 * i[2] };
        float v[3][3];
        for (int k = 0; k < 3; k++) project(positions + 3 * i[k], v[k]);
        draw_triangle(frame, v, light, albedo);
    }
}

/* ---- the program ---- */

static void make_surroundings(void)
{
    uint32_t *out = f.floor_indices;
    for (uint32_t i = 0; i < FLOOR; i++) {
        f.floor[3 * i] = 9 * (float)(i % GRID) / GRID - 6;
        f.floor[3 * i + 2] = 9 * (float)(i / GRID) / GRID - 6;
        f.floor_normals[3 * i + 1] = 1;
        if (i % GRID + 1 == GRID || i / GRID + 1 == GRID) continue;
        *out++ = i, *out++ = i + GRID, *out++ = i + 1;
        *out++ = i + 1, *out++ = i + GRID, *out++ = i + GRID + 1;
    }
    for (int i = 0; i < SKY; i++) {             /* even in the upper half of all directions */
        const float y = ((float)i + 0.5f) / SKY, r = sqrtf(1 - y * y), phi = 2.39996323f * (float)i;
        f.sky[3 * i] = r * cosf(phi), f.sky[3 * i + 1] = y, f.sky[3 * i + 2] = r * sinf(phi);
    }
    for (int i = 0; i < FRAMES * WIDTH * HEIGHT; i++) {
        depths[i] = 1e9f;
        picture[3 * i] = 148, picture[3 * i + 1] = 160, picture[3 * i + 2] = 179;
    }
}

int main(int count, char **values)
{
    static const float albedo[4][3] = { { 0.2f, 0.36f, 0.62f }, { 0.72f, 0.5f, 0.4f }, { 0.72f, 0.62f, 0.42f },
                                        { 0.6f, 0.6f, 0.58f } };
    cohsm_result result = COHSM_OK;
    double spent = 0;
    FILE *file;
    make_surroundings();
    for (int i = 0; i < 3; i++) make_shape(&shapes[i], i);
    for (int i = 0; i < SHAPES && result == COHSM_OK; i++) result = make_maps(i, &f.maps[i]);
    for (int i = 0; i < BONES; i++) f.bone[i].maps = f.maps[i < 2 ? i : UPPER + i % 2];
    for (int frame = 0; frame < FRAMES && result == COHSM_OK; frame++) {
        const clock_t start = clock();
        pose(f.bone, (float)frame / FRAMES, 1);
        for (int n = 0; n < SKINS; n++) bend_skin(&f.skins[n], f.bone, n);
        result = light_frame();
        spent += 1000.0 * (double)(clock() - start) / CLOCKS_PER_SEC;
        for (int n = 0; n < SKINS; n++)
            draw(frame, f.skins[n].drawn, f.skins[n].rgb, shapes[n < 2 ? n : 2].indices, TRIANGLES,
                 albedo[n < 2 ? n : 2]);
        draw(frame, f.floor, f.floor_rgb, f.floor_indices, 2 * (GRID - 1) * (GRID - 1), albedo[3]);
    }
    if (result == COHSM_OK) {
        printf("%d points on %d bones and %d on the floor, a sun and %d directions of sky: %.0f ms a frame\n",
               SKINS * VERTICES, BONES, FLOOR, SKY, spent / FRAMES);
        result = compare_all(0);
    }
    if (result == COHSM_OK) result = compare_all(1);
    if (result != COHSM_OK) return fprintf(stderr, "skinned: %s\n", cohsm_result_text(result)), 1;
    file = fopen(count > 1 ? values[1] : "step.ppm", "wb");
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    fprintf(file, "P6 %d %d 255\n", FRAMES * WIDTH, HEIGHT);
    fwrite(picture, 1, sizeof picture, file);
    for (int i = 0; i < SHAPES; i++) cohsm_free(f.maps[i]);
    return fclose(file) != 0;
}
