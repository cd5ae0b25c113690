/* object.c - see bake.h */
#include "bake.h"
#include "../render/csm_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static int is_wanted(const ex_object *o, const char *node)
{
    return *node ? strcmp(o->name, node) == 0 : !o->receiver_only;
}

/* Alpha masks are cut out of their triangles, as in render. */
static int gather(bk_mesh *out, const ex_scene *scene, const char *node, char *error)
{
    cs_soup soup = { NULL, NULL, 0, 0 };
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
    soup.positions = malloc((3 * vertices + 1) * sizeof *soup.positions);
    soup.indices = malloc((3 * triangles + 1) * sizeof *soup.indices);
    if (!soup.positions || !soup.indices) {
        free(soup.positions);
        free(soup.indices);
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    for (uint32_t i = 0; i < scene->object_count && found; i++)
        if (is_wanted(&scene->objects[i], node)) {
            cs_soup_add(&soup, scene, &scene->objects[i], *node ? identity : scene->objects[i].transform, 0);
            found--;
        }
    out->positions = soup.positions;
    out->indices = soup.indices;
    out->vertices = soup.vertices;
    out->triangles = soup.triangles;
    return 0;
}

int bk_object(bk_mesh *out, const char *path, const char *node, char *error)
{
    ex_scene scene;
    int result;
    memset(out, 0, sizeof *out);
    if (strncmp(path, "builtin:", 8) == 0)
        result = ex_scene_builtin(&scene, path + 8, 0, error);
    else
        result = ex_scene_load(&scene, path, error);
    if (result != 0)
        return -1;
    result = gather(out, &scene, node, error);
    ex_scene_free(&scene);
    return result;
}

void bk_object_free(bk_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
}
