/* emitters.c - the emissive triangles of a scene, in world space. */
#include "technique.h"

#include <math.h>
#include <stdlib.h>

static void to_world(const float *m, const float *p, float *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

static int is_mirrored(const float *m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]) < 0;
}

/* 0: without area */
static int fill(const ex_scene *scene, uint32_t object, uint32_t triangle, rd_emitter *e)
{
    const float *m = scene->objects[object].transform;
    const ex_mesh *mesh = &scene->meshes[scene->objects[object].mesh];
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    double a[3], b[3], n[3], length;
    int flip = is_mirrored(m);
    to_world(m, mesh->positions + 3 * (size_t)index[0], e->v[0]);
    to_world(m, mesh->positions + 3 * (size_t)index[flip ? 2 : 1], e->v[1]);
    to_world(m, mesh->positions + 3 * (size_t)index[flip ? 1 : 2], e->v[2]);
    for (int k = 0; k < 3; k++) {
        a[k] = (double)e->v[1][k] - (double)e->v[0][k];
        b[k] = (double)e->v[2][k] - (double)e->v[0][k];
    }
    n[0] = a[1] * b[2] - a[2] * b[1];
    n[1] = a[2] * b[0] - a[0] * b[2];
    n[2] = a[0] * b[1] - a[1] * b[0];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        e->normal[k] = (float)(n[k] / length);
    e->area = (float)(0.5 * length);
    e->object = object;
    e->triangle = triangle;
    e->material = ex_object_material(scene, &scene->objects[object], triangle);
    return e->area > 0;
}

int rd_emitters_build(const ex_scene *scene, rd_emitter **out, size_t *count)
{
    rd_emitter *list = NULL;
    size_t used = 0, room = 0;
    for (uint32_t object = 0; object < scene->object_count; object++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[object].mesh];
        for (uint32_t triangle = 0; triangle < mesh->triangle_count; triangle++) {
            uint32_t material = ex_object_material(scene, &scene->objects[object], triangle);
            const float *emission = scene->materials[material].emission;
            if (!(emission[0] > 0 || emission[1] > 0 || emission[2] > 0))
                continue;
            if (used == room) {
                rd_emitter *grown = realloc(list, (room = 2 * room + 64) * sizeof *list);
                if (!grown) {
                    free(list);
                    return -1;
                }
                list = grown;
            }
            used += (size_t)fill(scene, object, triangle, &list[used]);
        }
    }
    *out = list;
    *count = used;
    return 0;
}
