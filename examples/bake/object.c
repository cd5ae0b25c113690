/* object.c - see bake.h */
#include "bake.h"
#include "../render/args.h"
#include "../render/csm_parts.h"
#include "../render/shadowfield_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static int is_wanted(const ex_object *o, const char *node)
{
    return *node ? strcmp(o->name, node) == 0 : !o->receiver_only;
}

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "out of memory");
    return -1;
}

static float determinant(const float *m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]);
}

/* What triangles from `first` of the soup on emit, which are of this object. In the order of render, so that its bytes
   are the same. */
static void add_lit(bk_mesh *out, const cs_soup *soup, size_t first, const ex_object *o, int mirrored)
{
    for (size_t t = first; t < soup->triangles; t++) {
        const ex_material *material = &out->scene.materials[ex_object_material(&out->scene, o, soup->source[t])];
        const float *e = material->emission;
        const int both = material->double_sided && (out->as_film || e[0] > 0 || e[1] > 0 || e[2] > 0);
        for (int side = 0; side <= both; side++, out->lit_count++) {
            uint32_t *to = out->lit + 3 * out->lit_count;
            const uint32_t *from = soup->indices + 3 * t;
            memcpy(to, from, 3 * sizeof *to);
            if (side != mirrored)
                to[0] = from[1], to[1] = from[0];
            memcpy(out->radiance + 3 * out->lit_count, e, 3 * sizeof *e);
        }
    }
}

static int shines(const bk_mesh *m)
{
    for (size_t i = 0; i < 3 * m->lit_count; i++)
        if (m->radiance[i] > 0)
            return 1;
    return 0;
}

/* Alpha masks are cut out of their triangles, as csm does in render. */
static int gather(bk_mesh *out, char *error)
{
    const ex_scene *scene = &out->scene;
    const char *node = out->node;
    cs_soup soup = { NULL, NULL, NULL, 0, 0 };
    size_t vertices = 0, triangles = 0;
    uint32_t found = 0;
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (is_wanted(&scene->objects[i], node)) {
            if (*node && found)         /* instances: the first one's mesh is what they share */
                break;
            cs_soup_count(scene, &scene->objects[i], &vertices, &triangles);
            found++;
        }
    if (!triangles || vertices > UINT32_MAX) {
        snprintf(error, EX_ERROR_SIZE, "%s",
                 triangles ? "too many vertices"
                 : *node   ? "no node of that name with triangles"
                           : "nothing casts shadows");
        return -1;
    }
    out->positions = soup.positions = malloc((3 * vertices + 1) * sizeof *soup.positions);
    out->indices = soup.indices = malloc((3 * triangles + 1) * sizeof *soup.indices);
    out->lit = malloc((6 * triangles + 1) * sizeof *out->lit);
    out->radiance = malloc((6 * triangles + 1) * sizeof *out->radiance);
    soup.source = malloc((triangles + 1) * sizeof *soup.source);
    for (uint32_t i = 0; i < scene->object_count && found && soup.positions && soup.indices && out->lit &&
                         out->radiance && soup.source; i++)
        if (is_wanted(&scene->objects[i], node)) {
            const float *m = *node ? identity : scene->objects[i].transform;
            const size_t first = soup.triangles;
            cs_soup_add(&soup, scene, &scene->objects[i], m, 0);
            add_lit(out, &soup, first, &scene->objects[i], determinant(m) < 0);
            found--;
        }
    out->vertices = soup.vertices;
    out->triangles = soup.triangles;
    free(soup.source);
    if (found)
        return out_of_memory(error);
    if (!out->as_film && !shines(out)) {
        free(out->lit);
        free(out->radiance);
        out->lit = NULL;
        out->radiance = NULL;
        out->lit_count = 0;
    }
    return 0;
}

/* Does a path say a lamp, as in sphere:0,0,0,0.5? */
static int names_lamp(const char *path)
{
    static const char *const kinds[] = { "sphere:", "disc:", "rect:", "spot:", "point:" };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strncmp(path, kinds[i], strlen(kinds[i])) == 0)
            return 1;
    return 0;
}

/* As the scene is at a time. */
static int load(bk_mesh *out, const char *path, const char *node, double time, char *error)
{
    int result;
    out->path = path;
    snprintf(out->node, sizeof out->node, "%s", node);
    if (strncmp(path, "builtin:", 8) == 0)
        result = ex_scene_builtin(&out->scene, path + 8, (float)time, error);
    else
        result = ex_scene_load(&out->scene, path, error);
    if (result != 0)
        return -1;
    result = gather(out, error);
    if (result != 0)
        bk_object_free(out);
    return result;
}

int bk_object(bk_mesh *out, const char *path, const char *node, char *error)
{
    memset(out, 0, sizeof *out);
    if (names_lamp(path)) {
        rd_light_arg light;
        const int result = rd_light_parse(&light, path, error);
        out->lamp = light.light;
        out->lamp_text = path;
        return result;
    }
    return load(out, path, node, 0, error);
}

/* Appends what a frame's triangles shine to a film of i frames. */
static int add_frame(bk_mesh *film, const bk_mesh *now, uint32_t i, char *error)
{
    const size_t row = 3 * film->lit_count;
    float *grown;
    if (now->vertices != film->vertices || now->triangles != film->triangles || now->lit_count != film->lit_count ||
        memcmp(now->positions, film->positions, 12 * film->vertices) != 0 ||
        memcmp(now->indices, film->indices, 12 * film->triangles) != 0) {
        snprintf(error, EX_ERROR_SIZE, "frames: the object moves; name the node that shines");
        return -1;
    }
    grown = realloc(film->radiance, (row * (i + 1) + 1) * sizeof *grown);
    if (!grown)
        return out_of_memory(error);
    memcpy(grown + row * i, now->radiance, row * sizeof *grown);
    film->radiance = grown;
    return 0;
}

int bk_film(bk_mesh *out, const bk_mesh *mesh, uint32_t frames, double frames_per_second, char *error)
{
    int result = 0;
    memset(out, 0, sizeof *out);
    out->as_film = 1;
    if (load(out, mesh->path, mesh->node, 0, error) != 0)
        return -1;
    for (uint32_t i = 1; i < frames && result == 0; i++) {
        bk_mesh now;
        memset(&now, 0, sizeof now);
        now.as_film = 1;
        result = load(&now, mesh->path, mesh->node, i / frames_per_second, error);
        if (result == 0)
            result = add_frame(out, &now, i, error);
        bk_object_free(&now);
    }
    if (result != 0)
        bk_object_free(out);
    return result;
}

void bk_object_free(bk_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    free(mesh->lit);
    free(mesh->radiance);
    ex_scene_free(&mesh->scene);
    memset(mesh, 0, sizeof *mesh);
}

/* ---- points ---- */

/* Normals are turned by the cofactors. */
static int add_points(bk_points *p, const float *positions, const float *normals, size_t count, const float *m)
{
    const float side = determinant(m) < 0 ? -1.0f : 1.0f;
    float *grown = realloc(p->positions, (3 * (p->count + count) + 1) * sizeof *grown);
    p->positions = grown ? grown : p->positions;
    if (!grown || !(grown = realloc(p->normals, (3 * (p->count + count) + 1) * sizeof *grown)))
        return -1;
    p->normals = grown;
    for (size_t i = 0; i < count; i++, p->count++) {
        const float *from = positions + 3 * i, *n = normals + 3 * i;
        float *to = p->positions + 3 * p->count, *turned = p->normals + 3 * p->count, length = 0;
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            to[k] = m[k] * from[0] + m[4 + k] * from[1] + m[8 + k] * from[2] + m[12 + k];
            turned[k] = side * ((m[4 + a] * m[8 + b] - m[4 + b] * m[8 + a]) * n[0] +
                                (m[8 + a] * m[b] - m[8 + b] * m[a]) * n[1] +
                                (m[a] * m[4 + b] - m[b] * m[4 + a]) * n[2]);
            length += turned[k] * turned[k];
        }
        for (int k = 0; k < 3 && m != identity; k++)
            turned[k] = length > 0 ? turned[k] / sqrtf(length) : n[k];
    }
    return 0;
}

static float scale_of(const float *m) { return sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]); }

int bk_points_of(bk_points *out, const bk_mesh *mesh, float spacing, char *error)
{
    const ex_scene *scene = &mesh->scene;
    float center[3], radius;
    int result = 0;
    memset(out, 0, sizeof *out);
    if (ex_scene_bounds(scene, center, &radius) != 0)
        return out_of_memory(error);
    out->offset = 1e-3f * radius;
    for (uint32_t i = 0; i < scene->object_count && result == 0; i++) {
        const ex_object *o = &scene->objects[i];
        const ex_mesh *m = &scene->meshes[o->mesh];
        const float scale = fmaxf(scale_of(o->transform), 1e-12f), *to = *mesh->node ? identity : o->transform;
        sf_surface s;
        if (!is_wanted(o, mesh->node) || !m->triangle_count)
            continue;
        if (*mesh->node)
            out->offset = 1e-3f * radius / scale;
        if (!(spacing > 0))
            result = add_points(out, m->positions, m->normals, m->vertex_count, to);
        else {
            result = sf_surface_build(&s, scene, m, spacing * radius / scale, NULL);
            if (result == 0) {
                result = add_points(out, s.chosen_positions, s.chosen_normals, s.chosen_count, to);
                sf_surface_free(&s);
            }
        }
        if (*mesh->node)
            break;
    }
    if (result == 0)
        return 0;
    bk_points_free(out);
    return out_of_memory(error);
}

void bk_points_free(bk_points *points)
{
    free(points->positions);
    free(points->normals);
    memset(points, 0, sizeof *points);
}
