/* guest.c - the figures of a glTF file in another scene: its meshes under a skin or with morph targets, which move as
   the file's animation says. The file's own scene is kept beside the one that it is added to: a time poses it, and its
   vertices are copied. */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

struct ex_guest {
    ex_scene scene;              /* of the file */
    uint32_t first_mesh, first_object, first_material, first_texture;   /* of those that were added */
    float    at[3];
};

void ex_guest_free(ex_guest *guest)
{
    if (!guest) return;
    ex_scene_free(&guest->scene);
    free(guest);
}

static void *copy_of(const void *from, size_t count, size_t item)
{
    void *to = malloc(count * item + 1);
    if (to && from) memcpy(to, from, count * item);
    return to;
}

/* All textures and materials are added, so that numbers keep their order. */
static int add_looks(ex_scene *scene, const ex_guest *g)
{
    for (uint32_t i = 0; i < g->scene.texture_count; i++) {
        const ex_texture *from = &g->scene.textures[i];
        if (ex_grow(&scene->textures, &scene->texture_count, sizeof *scene->textures) != 0) return -1;
        ex_texture *to = &scene->textures[scene->texture_count - 1];
        to->rgba = copy_of(from->rgba, (size_t)from->width * from->height, 4);
        if (!to->rgba) return -1;
        to->width = from->width;
        to->height = from->height;
    }
    for (uint32_t i = 0; i < g->scene.material_count; i++) {
        if (ex_grow(&scene->materials, &scene->material_count, sizeof *scene->materials) != 0) return -1;
        ex_material *to = &scene->materials[scene->material_count - 1];
        *to = g->scene.materials[i];
        int *const textures[3] = {&to->base_texture, &to->normal_texture, &to->rough_texture};
        for (int k = 0; k < 3; k++)
            if (*textures[k] >= 0) *textures[k] += (int)g->first_texture;
    }
    return 0;
}

static int add_mesh(ex_scene *scene, const ex_guest *g, const ex_mesh *from)
{
    if (ex_grow(&scene->meshes, &scene->mesh_count, sizeof *scene->meshes) != 0) return -1;
    ex_mesh *to = &scene->meshes[scene->mesh_count - 1];
    to->positions = copy_of(from->positions, from->vertex_count, 3 * sizeof(float));
    to->normals = copy_of(from->normals, from->vertex_count, 3 * sizeof(float));
    if (from->uvs) to->uvs = copy_of(from->uvs, from->vertex_count, 2 * sizeof(float));
    if (from->parts) to->parts = copy_of(from->parts, from->vertex_count, sizeof *from->parts);
    to->indices = copy_of(from->indices, from->triangle_count, 3 * sizeof *from->indices);
    to->materials = copy_of(from->materials, from->triangle_count, sizeof *from->materials);
    if (!to->positions || !to->normals || (from->uvs && !to->uvs) || (from->parts && !to->parts) || !to->indices ||
        !to->materials)
        return -1;
    to->vertex_count = from->vertex_count;
    to->triangle_count = from->triangle_count;
    to->deforms = 1;
    for (uint32_t t = 0; t < to->triangle_count; t++) to->materials[t] += g->first_material;
    return 0;
}

/* Which number a mesh of the file has among those that were added. */
static uint32_t number_of(const ex_guest *g, uint32_t mesh)
{
    uint32_t number = g->first_mesh;
    while (mesh--) number += g->scene.meshes[mesh].deforms != 0;
    return number;
}

static int add_figures(ex_scene *scene, const ex_guest *g)
{
    for (uint32_t i = 0; i < g->scene.mesh_count; i++)
        if (g->scene.meshes[i].deforms && add_mesh(scene, g, &g->scene.meshes[i]) != 0) return -1;
    for (uint32_t i = 0; i < g->scene.object_count; i++) {
        const ex_object *from = &g->scene.objects[i];
        if (!g->scene.meshes[from->mesh].deforms) continue;
        if (ex_grow(&scene->objects, &scene->object_count, sizeof *scene->objects) != 0) return -1;
        ex_object *to = &scene->objects[scene->object_count - 1];
        *to = *from;
        to->mesh = number_of(g, from->mesh);
        if (to->material) to->material += g->first_material;
    }
    return 0;
}

int ex_guest_pose(ex_scene *scene, float time, char *error)
{
    ex_guest *g = scene->guest;
    uint32_t object = g->first_object;
    if (ex_scene_set_time(&g->scene, time, error) != 0) return -1;
    for (uint32_t i = 0; i < g->scene.mesh_count; i++) {
        const ex_mesh *from = &g->scene.meshes[i];
        if (!from->deforms) continue;
        ex_mesh *to = &scene->meshes[number_of(g, i)];
        if (to->vertex_count != from->vertex_count) continue;    /* the caller has taken it away: emitters=removed */
        memcpy(to->positions, from->positions, 3 * sizeof(float) * (size_t)to->vertex_count);
        memcpy(to->normals, from->normals, 3 * sizeof(float) * (size_t)to->vertex_count);
    }
    for (uint32_t i = 0; i < g->scene.object_count; i++) {
        const ex_object *from = &g->scene.objects[i];
        if (!g->scene.meshes[from->mesh].deforms) continue;
        float *to = scene->objects[object++].transform;
        memcpy(to, from->transform, sizeof from->transform);
        for (int k = 0; k < 3; k++) to[12 + k] += g->at[k];
    }
    return 0;
}

void ex_scene_keep_figures(ex_scene *scene)
{
    ex_guest_free(scene->guest);
    scene->guest = NULL;
}

int ex_scene_add_figures(ex_scene *scene, const char *path, const float at[3], char *error)
{
    int deforms = 0;
    ex_guest *g = calloc(1, sizeof *g);
    if (!g) return ex_fail(error, "%s: out of memory", path);
    if (ex_scene_load(&g->scene, path, error) != 0) {
        free(g);
        return -1;
    }
    ex_scene_keep_figures(scene);
    scene->guest = g;
    memcpy(g->at, at, sizeof g->at);
    g->first_mesh = scene->mesh_count;
    g->first_object = scene->object_count;
    g->first_material = scene->material_count;
    g->first_texture = scene->texture_count;
    for (uint32_t i = 0; i < g->scene.mesh_count; i++) deforms |= g->scene.meshes[i].deforms;
    if (!deforms) return ex_fail(error, "%s: has no mesh under a skin or with morph targets", path);
    if (add_looks(scene, g) != 0 || add_figures(scene, g) != 0) return ex_fail(error, "%s: out of memory", path);
    scene->animated = scene->animated || g->scene.animated;
    return ex_guest_pose(scene, 0, error);
}
