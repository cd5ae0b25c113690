/* 02_shadowfield_minimal.c - soft shadows of moving objects from shadow fields, with shadowfield.h and nothing else.

   cc -O2 02_shadowfield_minimal.c -lm -o minimal && ./minimal shadow.ppm

   One field of a torus, three instances that hover over a floor, one round lamp and a dim sky. The picture is the floor
   from above: where it is dark an instance hides the lamp. Objects may move every frame; only the last call is made
   again. */
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { SIZE = 256, RINGS = 40, SIDES = 20 };

static const float pi = 3.14159265f;

static float    positions[RINGS * SIDES * 3];
static uint32_t indices[RINGS * SIDES * 6];

static sfield_mesh make_torus(void)
{
    sfield_mesh mesh = { positions, RINGS * SIDES, 0, indices, RINGS * SIDES * 6, NULL, NULL, NULL };
    uint32_t i, j, k = 0;
    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++) {
            float a = 2 * pi * (float)i / RINGS, b = 2 * pi * (float)j / SIDES, *p = positions + 3 * (i * SIDES + j);
            uint32_t i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            p[0] = (1 + 0.35f * cosf(b)) * cosf(a);
            p[1] = 0.35f * sinf(b);
            p[2] = (1 + 0.35f * cosf(b)) * sinf(a);
            indices[k++] = i * SIDES + j, indices[k++] = i * SIDES + j2, indices[k++] = i2 * SIDES + j2;
            indices[k++] = i * SIDES + j, indices[k++] = i2 * SIDES + j2, indices[k++] = i2 * SIDES + j;
        }
    return mesh;
}

/* An instance: turned about the x axis, scaled, moved. */
static sfield_entity place(const sfield_field *occlusion, float angle, float scale, float x, float y, float z)
{
    sfield_entity e = upright;
    e.occlusion = occlusion;
    e.transform[0] = scale;
    e.transform[5] = e.transform[10] = scale * cosf(angle);
    e.transform[6] = scale * sinf(angle);
    e.transform[9] = -scale * sinf(angle);
    e.transform[12] = x, e.transform[13] = y, e.transform[14] = z;
    return e;
}

static int fail(const char *what, sfield_result result)
{
    fprintf(stderr, "%s: %s\n", what, sfield_result_text(result));
    return 1;
}

int main(int count, char **values)
{
    static float floor_points[3 * SIZE * SIZE], normals[3 * SIZE * SIZE], rgb[3 * SIZE * SIZE];
    const float sky[3] = { 0.10f, 0.12f, 0.16f };
    sfield_mesh mesh = make_torus();
    sfield_emitter lamp = { SFIELD_EMITTER_SPHERE, 0.6f, { 0 }, { 0 }, { 0 }, { 60, 55, 45 }, 0, NULL, NULL };
    sfield_entity entities[4];
    sfield_field *torus, *light;
    sfield_scene *scene;
    sfield_points points;
    sfield_desc desc;
    sfield_result result;
    FILE *file;
    int i, x, y;

    memset(&desc, 0, sizeof desc);
    desc.position_side = 12;                    /* 16 by default; this takes half the time */
    if ((result = sfield_build(&desc, &mesh, &torus, NULL)) != SFIELD_OK) return fail("torus", result);
    if ((result = sfield_build_emitter(&desc, &lamp, &light, NULL)) != SFIELD_OK) return fail("lamp", result);
    if ((result = sfield_scene_create(NULL, &scene)) != SFIELD_OK) return fail("scene", result);
    entities[0] = place(torus, 0.0f, 1.0f, -2.2f, 1.0f, 0.4f);
    entities[1] = place(torus, 1.2f, 0.8f, 1.8f, 1.2f, -1.5f);
    entities[2] = place(torus, 0.6f, 0.5f, 0.8f, 0.6f, 2.2f);
    entities[3] = place(NULL, 0, 1, 0, 5, 0);
    entities[3].source = light;
    if ((result = sfield_scene_entities(scene, entities, 4)) != SFIELD_OK) return fail("entities", result);
    if ((result = sfield_scene_environment(scene, sky, 1, 1, NULL)) != SFIELD_OK) return fail("sky", result);

    for (y = 0; y < SIZE; y++)
        for (x = 0; x < SIZE; x++) {
            float *p = floor_points + 3 * (y * SIZE + x);
            p[0] = 10.0f * ((float)x + 0.5f) / SIZE - 5;
            p[2] = 10.0f * ((float)y + 0.5f) / SIZE - 5;
            normals[3 * (y * SIZE + x) + 1] = 1;
        }
    memset(&points, 0, sizeof points);
    points.count = SIZE * SIZE;
    points.positions = floor_points;
    points.normals = normals;
    points.entity = 0;
    points.rgb = rgb;
    if ((result = sfield_shade(scene, &points, 1, NULL)) != SFIELD_OK) return fail("shade", result);

    file = fopen(count > 1 ? values[1] : "shadow.ppm", "wb");
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    fprintf(file, "P6 %d %d 255\n", SIZE, SIZE);
    for (i = 0; i < 3 * SIZE * SIZE; i++) {
        float radiance = 0.7f * rgb[i];         /* albedo 0.7 */
        radiance = radiance > 0 ? radiance < 1 ? radiance : 1 : 0;
        fputc((int)(255 * powf(radiance, 1 / 2.2f) + 0.5f), file);
    }
    sfield_scene_free(scene);
    sfield_free(torus);
    sfield_free(light);
    return fclose(file) != 0;
}
