/* shadowfield_bounce.c - see shadowfield_parts.h */
#include "shadowfield_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of an object that sends light on: what it gets at its patches, and what it makes of that. */
typedef struct body { sfield_bounce *bounce; uint32_t object; float *rgb; size_t points; } body;
struct sf_bounces { body *body; size_t count; };

/* The triangles that points of an object lie on are small enough to be patches. */
static sfield_result make_body(body *b, const sf_surface *surface, const ex_scene *scene, uint32_t object,
                               const sfield_desc *desc, uint32_t patches)
{
    const uint32_t own = scene->objects[object].material;
    sfield_mesh mesh;
    sfield_points points;
    float *albedo = malloc((3 * surface->triangle_count + 1) * sizeof *albedo);
    sfield_result r;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = surface->positions;
    mesh.vertex_count = surface->point_count;
    mesh.indices = surface->triangles;
    mesh.index_count = 3 * surface->triangle_count;
    if (!albedo)
        return SFIELD_ERR_ALLOC;
    for (size_t t = 0; t < surface->triangle_count; t++) {
        const uint32_t material = own ? own - 1 : surface->material[surface->triangles[3 * t]];
        for (int k = 0; k < 3; k++)
            albedo[3 * t + (size_t)k] = fminf(fmaxf(scene->materials[material].base_color[k], 0), 1);
    }
    r = sfield_bounce_create(desc, &mesh, albedo, patches, &b->bounce);
    free(albedo);
    if (r != SFIELD_OK)
        return r;
    sfield_bounce_points(b->bounce, &points);
    b->object = object;
    b->points = points.count;
    b->rgb = malloc(3 * points.count * sizeof *b->rgb);
    return b->rgb ? SFIELD_OK : SFIELD_ERR_ALLOC;
}

sfield_result sf_bounces_build(sf_bounces **out, const rd_job *job, const sf_surface *const *surface_of,
                               const sfield_entity *entities, const sfield_desc *desc)
{
    const ex_scene *scene = job->scene;
    sf_bounces *s = calloc(1, sizeof *s);
    sfield_result r = SFIELD_OK;
    sfield_desc d = *desc;
    d.shell_count = (uint32_t)rd_setting_integer(job->settings, "bounce_shell_count");
    d.position_side = (uint32_t)rd_setting_integer(job->settings, "bounce_position_side");
    *out = s;
    if (s)
        s->body = calloc(scene->object_count + (size_t)1, sizeof *s->body);
    if (!s || !s->body)
        return SFIELD_ERR_ALLOC;
    for (uint32_t i = 0; i < scene->object_count && r == SFIELD_OK; i++)
        if (surface_of[i] && entities[i].occlusion && !entities[i].source)
            r = make_body(&s->body[s->count++], surface_of[i], scene, i, &d,
                          (uint32_t)rd_setting_integer(job->settings, "patches"));
    return r;
}

sfield_result sf_bounces_light(sf_bounces *s, sfield_scene *scene, sfield_entity *entities, size_t entity_count)
{
    sfield_points *sets = calloc(s->count + 1, sizeof *sets);
    sfield_result r = SFIELD_OK;
    if (!sets)
        return SFIELD_ERR_ALLOC;
    for (size_t i = 0; i < s->count; i++) {
        entities[s->body[i].object].source = NULL;
        sfield_bounce_points(s->body[i].bounce, &sets[i]);
        sets[i].entity = s->body[i].object + 1;
        sets[i].rgb = s->body[i].rgb;
    }
    r = sfield_scene_entities(scene, entities, entity_count);
    if (r == SFIELD_OK)
        r = sfield_shade(scene, sets, s->count, NULL);
    for (size_t i = 0; i < s->count && r == SFIELD_OK; i++) {
        r = sfield_bounce_update(s->body[i].bounce, s->body[i].rgb);
        entities[s->body[i].object].source = sfield_bounce_source(s->body[i].bounce);
        for (int k = 0; k < 3; k++)
            entities[s->body[i].object].tint[k] = 1;
    }
    free(sets);
    return r == SFIELD_OK ? sfield_scene_entities(scene, entities, entity_count) : r;
}

void sf_bounces_free(sf_bounces *s)
{
    if (!s)
        return;
    for (size_t i = 0; i < s->count; i++) {
        sfield_bounce_free(s->body[i].bounce);
        free(s->body[i].rgb);
    }
    free(s->body);
    free(s);
}
