/* sfield_bones.c - what a bone hides of points close to it, where parts of articulated figures overlap each other's
   bounding spheres. A ball, limbs (capsules) and a trunk (a box) have a field each; points lie outside of the part at
   random, by how far they are from its centre, and look anywhere. What the field leaves of their cosine-weighted
   hemisphere is compared with rays, which meet these shapes in closed form. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { ROWS = 25, COLUMNS = 24, BANDS_OF_DISTANCE = 4, RAYS = 1024 };

/* A box of half axes `half`, its edges and corners rounded by `round`: box, capsule and ball in one. open: its mesh has
   no bottom. */
typedef struct part { const char *name; float half[3], round; int open; } part;

static const part parts[] = {
    { "ball", { 0, 0, 0 }, 1, 0 },
    { "limb 1:2", { 0, 0.5f, 0 }, 0.5f, 0 },
    { "limb 1:4", { 0, 0.75f, 0 }, 0.25f, 0 },
    { "limb 1:8", { 0, 0.875f, 0 }, 0.125f, 0 },
    { "trunk", { 0.4f, 0.7f, 0.2f }, 0.1f, 0 },
    { "open trunk", { 0.4f, 0.7f, 0.2f }, 0.1f, 1 },
    { "shield", { 0.65f, 0.65f, 0.02f }, 0.02f, 0 },
};

typedef struct setting { const char *name; float inner, outer; uint32_t shells, side; } setting;

static const setting settings[] = {
    { "default", 0, 0, 0, 0 },                  /* 16 shells from 0.2 to 8 r, 16 x 16 positions a face */
    { "side 8", 0, 0, 0, 8 },
    { "inner 0.05", 0.05f, 0, 0, 0 },
    { "inner 0.5", 0.5f, 0, 0, 0 },
    { "shells 32", 0, 0, 32, 0 },
    { "outer 2", 0, 2, 0, 0 },
    { "side 32", 0, 0, 0, 32 },
};

/* Radii between which points lie, in radii of the bounding sphere. */
static const float edges[BANDS_OF_DISTANCE + 1] = { 0, 0.2f, 0.6f, 1, 2 };

/* ---- shapes ---- */

/* How far p lies outside of the part; negative inside. */
static float distance_to(const part *s, const float *p)
{
    float sum = 0, deepest = -HUGE_VALF;
    for (int k = 0; k < 3; k++) {
        float q = fabsf(p[k]) - s->half[k];
        sum += q > 0 ? q * q : 0;
        deepest = fmaxf(deepest, q);
    }
    return sqrtf(sum) + fminf(deepest, 0) - s->round;
}

/* Does a ray meet the part? Steps of the distance itself never pass a surface; rays that graze it for very long count
   as free. */
static int meets(const part *s, const float *p, const float *d)
{
    float at[3] = { p[0], p[1], p[2] }, way = 0;
    for (int i = 0; i < 200 && way < 8; i++) {
        float step = distance_to(s, at);
        if (step < 1e-4f)
            return 1;
        way += step;
        for (int k = 0; k < 3; k++)
            at[k] += step * d[k];
    }
    return 0;
}

/* A rounded box is its box plus a ball: each octant of a ball's grid moves to its corner. The first row and the last
   are the middles of the top and the bottom. */
static int make_mesh(const part *s, ex_mesh *mesh)
{
    const uint32_t count = (ROWS + 1) * COLUMNS;
    uint32_t *i;
    memset(mesh, 0, sizeof *mesh);
    mesh->positions = malloc(3 * count * sizeof *mesh->positions);
    mesh->indices = i = malloc(6 * ROWS * COLUMNS * sizeof *mesh->indices);
    if (!mesh->positions || !mesh->indices)
        return -1;
    mesh->vertex_count = count;
    mesh->triangle_count = 2 * (ROWS - (s->open ? 1u : 0u)) * COLUMNS;
    for (uint32_t row = 0; row <= ROWS; row++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            /* Half a step aside no vertex lies between two octants. */
            const int pole = row == 0 || row == ROWS;
            float v = 3.14159265f * ((float)row - 0.5f) / (ROWS - 1);
            float u = 6.28318531f * ((float)column + 0.5f) / COLUMNS;
            float d[3] = { pole ? 0 : sinf(v) * cosf(u), pole ? (row ? -1.0f : 1.0f) : cosf(v),
                           pole ? 0 : sinf(v) * sinf(u) };
            uint32_t a = row * COLUMNS + column, b = row * COLUMNS + (column + 1) % COLUMNS;
            for (int k = 0; k < 3; k++)
                mesh->positions[3 * a + (uint32_t)k] = (float)((d[k] > 0) - (d[k] < 0)) * s->half[k] + s->round * d[k];
            if (row == ROWS || (s->open && row + 1 == ROWS))
                continue;
            *i++ = a, *i++ = b, *i++ = b + COLUMNS;
            *i++ = a, *i++ = b + COLUMNS, *i++ = a + COLUMNS;
        }
    return 0;
}

/* ---- points and their errors ---- */

typedef struct errors { bn_error all; double bias, worst; size_t dark, leaks; } errors;

static void random_direction(uint64_t *seed, float *d)
{
    float z = bn_random_in(seed, -1, 1), phi = bn_random_in(seed, 0, 6.28318531f), r = sqrtf(fmaxf(1 - z * z, 0));
    d[0] = r * cosf(phi), d[1] = r * sinf(phi), d[2] = z;
}

/* What rays see of the hemisphere about n, weighted by the cosine. */
static float trace(const part *s, const float *p, const float *n)
{
    float open = 0, all = 0;
    for (int i = 0; i < RAYS; i++) {
        float d[3], cosine = 0;
        bn_cap_direction(n, 1, i, RAYS, d);
        for (int k = 0; k < 3; k++)
            cosine += n[k] * d[k];
        all += cosine;
        open += meets(s, p, d) ? 0 : cosine;
    }
    return open / all;
}

/* Random points of one band of distance, off the part by more than a hundredth; returns how many there are: where the
   part fills the band, none. */
static size_t make_points(const part *s, const float *center, float radius, int band, size_t most, float *positions,
                          float *normals)
{
    uint64_t seed = 7 + (uint64_t)band;
    size_t count = 0;
    for (size_t tries = 0; tries < 200 * most && count < most; tries++) {
        float d[3], at = radius * bn_random_in(&seed, edges[band], edges[band + 1]), *p = positions + 3 * count;
        random_direction(&seed, d);
        for (int k = 0; k < 3; k++)
            p[k] = center[k] + at * d[k];
        random_direction(&seed, normals + 3 * count);
        count += distance_to(s, p) > 0.01f;
    }
    return count;
}

static int measure(const bn_options *options, const part *s, const setting *how, sfield_field *field, double seconds,
                   int band, size_t most)
{
    float *positions = malloc(7 * most * sizeof *positions), *normals = positions + 3 * most;
    float *ambient = normals + 3 * most;
    sfield_scene *scene = NULL;
    sfield_entity e = upright;
    sfield_points set;
    sfield_info info;
    errors out;
    sfield_get_info(field, &info);
    memset(&out, 0, sizeof out);
    memset(&set, 0, sizeof set);
    e.occlusion = field;
    if (!positions || sfield_scene_create(NULL, &scene) != SFIELD_OK) {
        free(positions);
        return -1;
    }
    set.count = make_points(s, info.center, info.radius, band, most, positions, normals);
    set.positions = positions;
    set.normals = normals;
    set.ambient = ambient;
    if (sfield_scene_entities(scene, &e, 1) != SFIELD_OK || sfield_shade(scene, &set, 1, NULL) != SFIELD_OK) {
        sfield_scene_free(scene);
        free(positions);
        return -1;
    }
    for (size_t i = 0; i < set.count; i++) {
        const double truth = (double)trace(s, positions + 3 * i, normals + 3 * i), value = (double)ambient[i];
        bn_error_add(&out.all, value, truth);
        out.bias += (value - truth) / (double)set.count;
        out.worst = fmax(out.worst, fabs(value - truth));
        out.dark += value < truth - 0.25;
        out.leaks += value > truth + 0.25;
    }
    if (set.count) {
        bn_begin(options, "sfield_bones", options->threads, bn_sfield_simd());
        bn_text("part", s->name);
        bn_text("field", how->name);
        bn_number("from_r", (double)edges[band]);
        bn_number("to_r", (double)edges[band + 1]);
        bn_integer("points", set.count);
        bn_number("build_seconds", seconds);
        bn_integer("bytes", sfield_bytes(field));
        bn_number("open", out.all.sum / (double)set.count);
        bn_number("bias", out.bias);
        bn_number("rmse", sqrt(out.all.square / (double)set.count));
        bn_number("worst", out.worst);
        bn_integer("too_dark", out.dark);
        bn_integer("leaks", out.leaks);
        bn_end(options);
    }
    sfield_scene_free(scene);
    free(positions);
    return 0;
}

int bn_sfield_bones(const bn_options *options)
{
    int result = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && result == 0; i++)
        for (size_t j = 0; j < sizeof settings / sizeof *settings - !options->full && result == 0; j++) {
            sfield_desc d = bn_sfield_desc(options);
            sfield_field *field = NULL;
            double start = ex_seconds();
            ex_mesh mesh;
            sfield_mesh input = { NULL, 0, 0, NULL, 0, NULL, NULL, NULL };
            d.inner = settings[j].inner;
            d.outer = settings[j].outer;
            d.shell_count = settings[j].shells;
            d.position_side = settings[j].side;
            result = make_mesh(&parts[i], &mesh);
            input.positions = mesh.positions;
            input.vertex_count = mesh.vertex_count;
            input.indices = mesh.indices;
            input.index_count = 3 * (size_t)mesh.triangle_count;
            if (result == 0 && sfield_build(&d, &input, &field, NULL) != SFIELD_OK)
                result = -1;
            start = ex_seconds() - start;
            for (int band = 0; band < BANDS_OF_DISTANCE && result == 0; band++)
                result = measure(options, &parts[i], &settings[j], field, start, band, options->full ? 4000 : 500);
            sfield_free(field);
            free(mesh.positions);
            free(mesh.indices);
        }
    return result == 0 ? 0 : bn_failed("sfield_bones", "out of memory");
}
