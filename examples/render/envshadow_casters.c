/* envshadow_casters.c - what casts shadows, for both back ends. A ground that only receives is drawn too, since it
   keeps light from below out, but the maps are not fitted to it. */
#include "envshadow_parts.h"
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>

void es_casters_free(es_state *s)
{
    for (uint32_t i = 0; i < s->caster_count; i++) {
        free(s->casters[i].positions);
        free(s->casters[i].indices);
    }
    free(s->casters);
    s->casters = NULL;
    s->caster_count = 0;
}

static int cut_holes(es_caster *c, const ex_scene *scene, const ex_object *object, char *error)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    cs_soup soup = { NULL, NULL, NULL, 0, 0 };
    size_t vertices = 0, triangles = 0;
    cs_soup_count(scene, object, &vertices, &triangles);
    soup.positions = c->positions = malloc(3 * (vertices + 1) * sizeof *c->positions);
    soup.indices = c->indices = malloc(3 * (triangles + 1) * sizeof *c->indices);
    if (!c->positions || !c->indices)
        return es_refuse("out of memory", error);
    cs_soup_add(&soup, scene, object, identity, 0);
    c->mesh.positions = soup.positions;
    c->mesh.vertex_count = soup.vertices;
    c->mesh.indices = soup.indices;
    c->mesh.index_count = 3 * soup.triangles;
    c->mesh.mask_fn = NULL;
    return 0;
}

int es_casters_build(es_state *s, const ex_scene *scene, int cut, char *error)
{
    es_casters_free(s);
    s->casters = calloc((size_t)scene->object_count + 1, sizeof *s->casters);
    if (!s->casters)
        return es_refuse("out of memory", error);
    s->caster_count = scene->object_count;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        es_caster *c = &s->casters[i];
        envsh_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices, 3 * (size_t)mesh->triangle_count,
                         NULL, NULL, NULL };
        c->mesh = m;
        c->transform = object->transform;
        c->moves = mesh->deforms;
        c->receiver_only = object->receiver_only;
        if (!cs_has_holes(scene, object))
            continue;
        c->masked.scene = scene;
        c->masked.object = object;
        c->mesh.mask_fn = cs_is_there;
        c->mesh.user = &c->masked;
        if (cut && cut_holes(c, scene, object, error) != 0)
            return -1;
    }
    return 0;
}

envsh_bounds es_casters_bounds(const es_state *s)
{
    envsh_bounds all = envsh_bounds_of(NULL, 0, NULL);
    for (uint32_t i = 0; i < s->caster_count; i++) {
        envsh_bounds one;
        if (s->casters[i].receiver_only)
            continue;
        one = envsh_bounds_of(&s->casters[i].mesh, 1, s->casters[i].transform);
        for (int k = 0; k < 3; k++) {
            all.low[k] = fminf(all.low[k], one.low[k]);
            all.high[k] = fmaxf(all.high[k], one.high[k]);
        }
    }
    return all;
}

envsh_result es_casters_draw(const es_state *s, envsh_maps *maps)
{
    envsh_result result = ENVSH_OK;
    for (uint32_t i = 0; i < s->caster_count && result == ENVSH_OK; i++)
        result = envsh_maps_draw(maps, &s->casters[i].mesh, s->casters[i].transform);
    return result;
}
